"""Where a sweep is killed, what its second step is then, and how often the spheres fly in all."""

POINTS = {
    "step taken": ("not_fired", 3),
    "row accepted": ("not_fired", 3),
    "row firing": ("unknown", 2),
    "before the byte": ("unknown", 2),
    "after the byte": ("unknown", 3),
    "row capturing": ("lost", 3),
    "collect": ("lost", 3),
    "folder whole, row to come": ("stored", 3),
    "row stored": ("stored", 3),
    "step ended": ("stored", 3),
}

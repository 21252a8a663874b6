"""A virtual machine with Debian's own kernel, started on the files of this machine, read-only.

Emulated (no KVM), so that it runs wherever QEMU does. Debian packages: `PACKAGES`.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

PACKAGES = (
    "qemu-system-x86",
    "seabios",
    "ipxe-qemu",
    "busybox-static",
    "v4l-utils",
    "zstd",
    "cpio",
    "libusb-1.0-0",
)
NEEDS = ("qemu-system-x86_64", "busybox", "v4l2-ctl", "cpio", "apt-get", "dpkg-deb")
MODULES = ("virtio_pci", "9pnet_virtio", "9p", "overlay", "vivid", "vhci-hcd", "cdc-acm", "usbhid")
GUEST_S = 200.0
"""Longest run of a guest, s."""

_INIT = """#!/bin/busybox sh
/bin/busybox mkdir -p /proc /sys /dev /lower /upper /root_ /bin
/bin/busybox --install -s /bin
echo "{started}"
mount -t proc proc /proc; mount -t sysfs sys /sys; mount -t devtmpfs dev /dev
while read module; do
    case $module in *vivid.ko) arguments="{vivid}";; *) arguments=;; esac
    insmod /modules/$module $arguments || echo "KERNEL no $module"
done < /modules/order
mount -t 9p -o trans=virtio,version=9p2000.L,ro,msize=524288,cache=loose hostroot /lower
mount -t tmpfs tmpfs /upper; mkdir /upper/over /upper/work
mount -t overlay -o lowerdir=/lower,upperdir=/upper/over,workdir=/upper/work overlay /root_
for each in proc sys dev; do mkdir -p /root_/$each; mount --rbind /$each /root_/$each; done
mkdir -p /root_/dev/pts /root_/dev/shm; mount -t devpts devpts /root_/dev/pts
mount -t tmpfs tmpfs /root_/dev/shm; mount -t tmpfs tmpfs /root_/tmp
chroot /root_ /bin/sh -c '{command}' < /dev/null 2>&1
echo "GUEST RC=$?"
poweroff -f
"""
STARTED = "GUEST STARTED"
_VIVID = (
    "n_devs=1 node_types=0x101 num_inputs=2 input_types=0x0C num_outputs=1 output_types=1 "
    "multiplanar=1 vid_cap_nr=0 vid_out_nr=1"
)


def missing() -> list[str]:
    """Return the programs that are not installed here."""
    return [name for name in NEEDS if shutil.which(name) is None]


def kernel(folder: Path) -> Path:
    """Unpack Debian's kernel, without installing it, into a folder; return where it lies.

    Raises
    ------
    subprocess.CalledProcessError, IndexError
        The package cannot be had.
    """
    unpacked = folder / "unpacked"
    if not list(unpacked.glob("boot/vmlinuz-*")):
        depends = _said("apt-cache", "depends", "linux-image-amd64")
        package = re.findall(r"linux-image-\d\S*", depends)[0]
        folder.mkdir(parents=True, exist_ok=True)
        subprocess.run(["apt-get", "download", package], cwd=folder, check=True)
        [archive] = folder.glob("linux-image-*.deb")
        subprocess.run(["dpkg-deb", "-x", str(archive), str(unpacked)], check=True)
        archive.unlink()
    return unpacked


def run(unpacked: Path, folder: Path, command: list[str]) -> tuple[int, str]:
    """Boot, run a command on this machine's files; return its status and the console.

    A guest that has not ended within `GUEST_S` is stopped, its status is then -1.
    """
    image = _initial_files(unpacked, folder, " ".join(command))
    [linux] = unpacked.glob("boot/vmlinuz-*")
    words = [
        *("qemu-system-x86_64", "-accel", "tcg,thread=multi", "-machine", "q35"),
        *("-cpu", "max", "-smp", "2", "-m", "1024", "-nodefaults", "-no-user-config"),
        *("-display", "none", "-no-reboot", "-serial", "stdio"),
        *("-kernel", str(linux), "-initrd", str(image)),
        *("-append", "console=ttyS0 quiet panic=-1"),
        "-virtfs",
        "local,path=/,mount_tag=hostroot,security_model=none,readonly=on,multidevs=remap",
    ]
    path = folder / "console"
    with path.open("wb") as file:
        machine = subprocess.Popen(
            words, stdout=file, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL
        )
        try:
            machine.wait(GUEST_S)
        except subprocess.TimeoutExpired:
            machine.kill()
            machine.wait()
    console = path.read_text(errors="replace")
    ended = re.search(r"GUEST RC=(\d+)", console)
    return (int(ended[1]) if ended else -1), console


def python(module: Path) -> list[str]:
    """Return the command that runs a file in the guest with this very environment."""
    root = Path(__file__).parents[2]
    return [
        f"cd {root} &&",
        "PYTHONDONTWRITEBYTECODE=1",
        f"PYTHONPATH={root / 'src'}:{root}",
        sys.executable,
        str(module),
    ]


def _initial_files(unpacked: Path, folder: Path, command: str) -> Path:
    """Pack busybox, the modules in the order of their needs, and what starts first."""
    files = folder / "initial"
    shutil.rmtree(files, ignore_errors=True)
    (files / "modules").mkdir(parents=True)
    (files / "bin").mkdir()
    shutil.copy(shutil.which("busybox") or "", files / "bin" / "busybox")
    names = []
    for module in _in_order(unpacked):
        shutil.copy(module, files / "modules" / module.name)
        names.append(module.name)
    (files / "modules" / "order").write_text("\n".join(names) + "\n")
    init = files / "init"
    init.write_text(_INIT.format(started=STARTED, vivid=_VIVID, command=command))
    init.chmod(0o755)
    image = folder / "initial.gz"
    subprocess.run(
        f"find . | cpio --quiet -o -H newc | gzip -1 > {image}",
        shell=True,
        cwd=files,
        check=True,
    )
    return image


def _in_order(unpacked: Path) -> list[Path]:
    """Return the modules' files, each after those that it needs (modules.dep by busybox)."""
    [tree] = unpacked.glob("lib/modules/*")
    dependencies = tree / "modules.dep"
    if not dependencies.exists() or not dependencies.stat().st_size:
        subprocess.run(["busybox", "depmod", "-b", str(unpacked), tree.name], check=True)
    needs = {}
    for line in dependencies.read_text().splitlines():
        path, _, needed = line.partition(":")
        needs[path] = needed.split()
    by_name = {Path(path).name.partition(".")[0].replace("-", "_"): path for path in needs}
    ordered: list[str] = []

    def add(path: str) -> None:
        for needed in needs[path]:
            add(needed)
        if path not in ordered:
            ordered.append(path)

    for name in MODULES:
        path = by_name.get(name.replace("-", "_"))
        if path:  # what is missing is built into the kernel
            add(path)
    return [tree / path for path in ordered]


def _said(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout

"""A nuisance that a fit pulls beyond three stated errors is an alarm; one within is none."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from analysis.effects.contact.lasting_contact import EFFECT
from analysis.model.data.poses import PoseData
from analysis.model.fitting.nuisance import MOST_PULL, alarms_of, nuisances
from analysis.model.fitting.nuisance_words import alarm_sentences
from analysis.model.fitting.robust_fit import RobustFit, robust_fit
from analysis.model.verdict.documents import fit_document
from benchmarks.discovery.campaigns import posed
from simulators.challenge.campaign import run_campaign
from simulators.challenge.force_choice import Forces
from simulators.challenge.nature import Nature


@cache
def poses(drag: float, longer: float = 1.0) -> PoseData:
    """Return poses in air whose drag is stated as 0.42 +- 0.2, and a scale that may be off."""
    made = posed(run_campaign(Nature(forces=Forces(), drag_coefficient=drag), 7, shots=60))
    stated = replace(made, drag_coefficient=0.42, slow=replace(made.slow, scale=5e-4))
    return replace(stated, position=longer * stated.position)


@cache
def fitted(drag: float, longer: float = 1.0) -> RobustFit:
    return robust_fit(poses(drag, longer), [EFFECT])


def test_what_is_stated_rightly_raises_no_alarm() -> None:
    found = fitted(0.4)
    assert {one.name for one in nuisances(found.fit)} >= {"drag.Cd", "image-scale.s"}
    assert alarms_of(found.fit) == ()


def test_a_drag_far_from_what_is_stated_is_an_alarm() -> None:
    (alarm,) = alarms_of(fitted(2.0).fit)
    assert alarm.name == "drag.Cd"
    assert alarm.stated.value == pytest.approx(0.42)
    assert alarm.found.value > 1.0
    assert alarm.pull > MOST_PULL
    (sentence,) = alarm_sentences([alarm])
    assert "pulls it to" in sentence
    assert "measure it anew" in sentence


@pytest.mark.long
def test_a_scale_far_from_what_is_stated_is_an_alarm() -> None:
    """Lengths 0.5 % too long where 0.05 % is stated."""
    named = {alarm.name: alarm for alarm in alarms_of(fitted(0.4, 1.005).fit)}
    assert 2e-3 < named["image-scale.s"].found.value < 5.5e-3


def test_a_law_that_lacks_something_is_seen_by_what_it_does_to_the_nuisances() -> None:
    """Hard spheres are no law of these contacts; scale and drag make up for it."""
    assert alarms_of(robust_fit(poses(0.4)).fit)


def test_several_alarms_are_one_sentence_the_farthest_first() -> None:
    alarms = alarms_of(robust_fit(poses(0.4)).fit)
    (sentence,) = alarm_sentences(alarms)
    assert len(alarms) > 1
    assert sentence.startswith(f"Alarm: {alarms[0].name} is stated")
    assert all(sentence.count(alarm.name) == 1 for alarm in alarms)
    assert alarm_sentences([]) == []


def test_documents_of_fits_hold_the_alarms() -> None:
    document = fit_document("soft", ["lasting-contact"], fitted(2.0))
    assert [alarm["nuisance"] for alarm in document["alarms"]] == ["drag.Cd"]

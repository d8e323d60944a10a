"""Cases and their solutions."""

from __future__ import annotations

import doctest
import importlib
import json
import math
import pathlib
import pickle
import subprocess
import threading
import time
from collections.abc import Callable

import numpy as np
import pytest

import fre

# What differs from run to run.
MEASURED = "elapsed_us"


def without_times(text: str) -> list[dict[str, object]]:
    places = json.loads(text)
    for place in places:
        place.pop(MEASURED)
    return list(places)


@pytest.mark.parametrize(
    "name", ["block-parallel.toml", "bore.toml", "cylinder-mid.toml", "ellipse.toml", "wall.toml"]
)
def test_results_are_those_of_the_command_to_the_last_digit(program: str, examples: pathlib.Path, name: str) -> None:
    run = subprocess.run([program, "solve", examples / name, "--format", "json"], capture_output=True, text=True)
    assert run.returncode in (0, 2), run.stderr
    solution = fre.solve(examples / name)
    assert without_times(solution.json()) == without_times(run.stdout)
    # Attributes have the same digits.
    for place, expected in zip(solution, json.loads(run.stdout)):
        assert place.status.value == expected["status"]
        if expected["force_n"] is not None:
            assert place.force_n.tolist() == expected["force_n"]
            assert place.front_mm.tolist() == expected["front_mm"]
            assert place.sensitivity is not None
            assert place.sensitivity["force_per_centre_mm_n"].tolist() == expected["sensitivity"]["force_per_centre_mm_n"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (fre.Options(scheme="paper", elements="24/3", physics="paper"), ["--scheme", "paper", "--elements", "24/3", "--physics", "paper"]),
        (fre.Options(elements="reduced", precision="f32"), ["--elements", "reduced", "--precision", "f32"]),
        (fre.Options(samples=2, softness_mm_per_n=1e-3), ["--samples", "2", "--softness-mm-per-n", "1e-3"]),
    ],
)
def test_options_are_those_of_the_command(
    program: str, examples: pathlib.Path, options: fre.Options, words: list[str]
) -> None:
    case = examples / "cylinder-mid.toml"
    run = subprocess.run([program, "solve", case, "--format", "json", *words], capture_output=True, text=True)
    assert without_times(fre.solve(case, options).json()) == without_times(run.stdout)


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_every_name_of_the_json_is_an_attribute(case: fre.Case, friction: float) -> None:
    solution = fre.solve(case.with_values({"object.friction": friction}))
    for place in solution:
        for name, value in place.to_dict().items():
            found = getattr(place, name)
            if isinstance(value, list) and value:
                assert len(found) == len(value), name
        # Beside what may come later, the names that a type checker sees are those of the JSON.
        seen = {name for name in vars(fre.Place) if not name.startswith("_")} - {"to_dict"}
        seen -= {"status"}
        optional = {"distance_mm", "time_s", "ribs_mm"} | (set() if friction else {"friction", "force_interval_n"})
        assert seen - optional <= set(place.to_dict()), seen - set(place.to_dict())


def read(record: fre.Place | fre.Record) -> None:
    """Reads every name of a place, and of all records in it."""
    for name in record.to_dict():
        found = getattr(record, name)
        for entry in found if isinstance(found, tuple) else [found]:
            if isinstance(entry, fre.Record):
                read(entry)


@pytest.mark.parametrize("preset", fre.PRESETS)
def test_every_name_can_be_read_of_every_preset(preset: str) -> None:
    finger = fre.Finger.preset(preset)
    x = 41.0 if preset != "umi" else 21.0
    solution = fre.solve(fre.Case(finger, fre.Circle(x - 1.0, (x, 40.0)), fre.Translation((1.0, 0.0), [0.0, 2.0])))
    assert solution[-1].status is fre.Status.converged and len(solution[-1].contacts) > 0
    for place in solution:
        read(place)
    ribs = solution[-1].ribs_mm
    if "kind" not in finger.to_dict()["lamellae"]:
        assert ribs == ()
        return
    assert len(ribs) == len(finger["lamellae.front_arc_mm"])
    assert all(rib.shape == (len(rib), 2) and not rib.flags.writeable for rib in ribs)
    assert [rib.tolist() for rib in ribs] == solution[-1].to_dict()["ribs_mm"]


def test_a_column_of_what_is_not_rectangular_is_refused_by_name() -> None:
    case = fre.Case("preset:umi", fre.Circle(20.0, (21.0, 40.0)), fre.Translation((1.0, 0.0), [0.0, 2.0]))
    solution = fre.solve(case)
    assert len({len(rib) for rib in solution[-1].ribs_mm}) > 1
    for name in ("ribs_mm", "model.scheme"):
        with pytest.raises(fre.CaseError, match=f"{name}: a column needs numbers") as error:
            solution.column(name)
        assert error.value.key == name


def test_results_compare_by_what_they_hold_and_are_copied(case: fre.Case) -> None:
    place = fre.solve(case)[-1]
    again = fre.Place(place.to_dict())
    assert place == again and place in (again,) and place.contacts == again.contacts and place.model == again.model
    assert place.contacts[0] != place.contacts[1] and place.contacts[0] in again.contacts
    assert place.model == place.to_dict()["model"] and place.model != 3
    found = place.to_dict()
    found["front_mm"][0][0] = 1e9
    found["model"]["scheme"] = "mine"
    found["strains"].clear()
    assert place == again and place.to_dict() == again.to_dict()
    assert place.beyond_max_strain == ()


def test_cases_compare_by_what_they_say(case: fre.Case) -> None:
    for finger in fre.PRESETS:
        motion = fre.Translation((1, 0), [0, 2])
        one = fre.Case(f"preset:{finger}", fre.Circle(40, (41, 45)), motion)
        other = fre.Case(one.finger, one.object, one.motion)
        assert one == other and hash(one) == hash(other), finger
        thick = fre.Case(one.finger.with_values({"front.thickness_mm": 1.75}), one.object, motion)
        assert thick != one and len({one, other, thick}) == 2
    plain = fre.Case.parse(case.toml().replace("friction = 0.0\n", ""))
    assert "friction" not in plain.toml() and plain == case and plain != case.finger
    whole, part = (fre.Finger({**case.finger.to_dict(), "width_mm": width}) for width in (20, 20.0))
    assert whole == part and hash(whole) == hash(part)


def test_arrays_of_all_places_are_the_places_own(case: fre.Case) -> None:
    solution = fre.solve(case)
    assert len(solution) == 4 and solution[-1] == list(solution)[3]
    assert solution.force_n.shape == (4, 2)
    for name in ("force_n", "force_magnitude_n", "motor_torque_nmm", "energy_nmm", "tip_mm"):
        expected = [getattr(place, name) for place in solution]
        np.testing.assert_array_equal(getattr(solution, name), np.array(expected))
    np.testing.assert_array_equal(solution.places, [-2.0, 2.0, 4.0, 8.0])
    assert [status.name for status in solution.status] == ["no_contact", "converged", "converged", "converged"]
    assert solution.is_trustworthy
    np.testing.assert_array_equal(
        solution.column("max_strain.front"), [place.to_dict()["max_strain"]["front"] for place in solution]
    )
    with pytest.raises(ValueError):
        solution[1].front_mm[0, 0] = 1.0
    with pytest.raises(IndexError):
        solution[4]


def test_without_a_trustworthy_status_there_is_no_number() -> None:
    # The object is around the finger and its motor: no angle is free of contact.
    case = fre.Case("preset:ladder-80", fre.Circle(200.0, (41.0, 45.0)), fre.Rotation([0.0, 5.0]))
    solution = fre.solve(case)
    bad = solution[-1]
    assert bad.status is fre.Status.out_of_range
    assert not bad.status.is_trustworthy and not solution.is_trustworthy
    assert np.isnan(bad.force_n).all() and np.isnan(bad.force_magnitude_n) and bad.front_mm.shape == (0, 2)
    assert bad.max_strain is None and bad.contacts == ()
    assert np.isnan(solution.force_magnitude_n).all() and "<svg" not in (solution.svg() or "")


def test_statuses_have_the_words_of_the_contract() -> None:
    words = (
        "converged tracking no-contact snapped max-iterations stagnated folded contact-capacity out-of-range stale "
        "precision unsettled updating"
    )
    assert [status.value for status in fre.Status] == words.split()
    assert all(status.name == status.value.replace("-", "_") for status in fre.Status)
    assert [status.name for status in fre.Status if status.is_trustworthy] == ["converged", "tracking", "no_contact", "snapped"]


def test_everything_can_be_pickled(case: fre.Case) -> None:
    solution = fre.solve(case)
    for thing in (case, case.finger, case.object, case.motion, fre.Options(elements="48/2"), fre.Status.folded):
        assert pickle.loads(pickle.dumps(thing)) == thing
    again = pickle.loads(pickle.dumps(solution))
    assert again.json() == solution.json() and again.case == case and again.svg() == solution.svg()
    place = pickle.loads(pickle.dumps(solution[2]))
    assert place == solution[2]
    assert pickle.loads(pickle.dumps(solution[2].max_strain)) == solution[2].max_strain


def test_a_notebook_shows_the_picture_of_the_command(program: str, examples: pathlib.Path, tmp_path: pathlib.Path) -> None:
    case = examples / "cylinder-mid.toml"
    subprocess.run([program, "solve", case, "--plot", tmp_path / "p.svg"], check=True, capture_output=True)
    solution = fre.solve(case)
    assert solution._repr_svg_() == (tmp_path / "p.svg").read_text()
    strain = solution.svg("strain", at=0)
    assert strain is not None and strain.startswith("<svg") and strain != solution.svg("strain")
    with pytest.raises(ValueError, match="kind = \"side\": allowed is finger, force, loop, pressure, strain"):
        solution.svg("side")  # type: ignore[arg-type]


def test_bad_input_names_its_key() -> None:
    circle, motion = fre.Circle(40.0, (41.0, 45.0)), fre.Rotation([2.0])
    with pytest.raises(fre.CaseError) as error:
        fre.Case(fre.Finger.preset("ladder-80").with_values({"front.thickness_mm": -1.0}), circle, motion)
    assert isinstance(error.value, ValueError)
    assert error.value.key == "finger.front.thickness_mm" and "allowed is" in str(error.value)
    with pytest.raises(fre.CaseError) as error:
        fre.Case("preset:ladder-80", fre.Circle(-1.0, (41.0, 45.0)), motion)
    assert error.value.key == "object.radius_mm"
    with pytest.raises(fre.CaseError) as error:
        fre.Case(fre.Finger.preset("ladder-80").with_values({"front.thicknes_mm": 2.0}), circle, motion)
    assert error.value.key == "finger.front.thicknes_mm" and "thickness_mm" in str(error.value)
    with pytest.raises(fre.CaseError, match="object.radius_mm") as error:
        fre.Case("preset:ladder-80", circle, motion).with_values({"object.radius": 2.0})
    assert error.value.key == "object.radius"
    for options, key in [({"scheme": "euler"}, "scheme"), ({"elements": "1"}, "elements"), ({"samples": 17}, "samples")]:
        with pytest.raises(fre.CaseError) as error:
            fre.Options(**options)  # type: ignore[arg-type]
        assert error.value.key == key
    with pytest.raises(fre.CaseError) as error:
        fre.solve(fre.Case("preset:ladder-80", circle, motion), fre.Options(softness_mm_per_n=-1.0))
    assert error.value.key == "softness_mm_per_n"


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("lamellae.heights_mm.99", 3.0),
        ("lamellae.heights_mm.-1", 3.0),
        ("lamellae.heights_mm.a", 3.0),
        ("front.thickness_mm.a.b", 3.0),
        ("front.thickness_mm.a", 3.0),
    ],
)
def test_an_entry_that_a_finger_has_not_is_named(key: str, value: float) -> None:
    with pytest.raises(fre.CaseError, match=f"^finger.{key}: ") as refused:
        fre.Finger.preset("ladder-80").with_values({key: value})
    assert refused.value.key == f"finger.{key}"


def test_what_is_not_a_number_is_named(case: fre.Case) -> None:
    with pytest.raises(fre.CaseError, match="object.radius_mm: allowed is a number, not 'x'"):
        case.with_values({"object.radius_mm": "x"})  # type: ignore[dict-item]
    for values in (["x"], [[1.0, 2.0]], [1j]):
        with pytest.raises(fre.CaseError, match="object.radius_mm: allowed is a number or a list of numbers"):
            fre.solve_many(case, {"object.radius_mm": values})  # type: ignore[dict-item]
    with pytest.raises(TypeError, match="None is not a number, a text, a list or a table"):
        fre.Finger({"lamellae": {"heights_mm": [1.0, None]}})


def test_every_error_has_a_key_and_a_line_to_look_at(case: fre.Case) -> None:
    error = fre.CaseError("words")
    assert error.key is None and error.line is None
    with pytest.raises(fre.CaseError) as found:
        fre.solve_many(case, {"object.radius_mm": [40.0], "object.centre_mm.1": [40.0, 50.0]})
    assert (found.value.key, found.value.line) == ("values", None)
    with pytest.raises(fre.CaseError) as found:
        fre.Finger.preset("ladder-80").with_values({"name.first": 1.0})
    assert found.value.key == "finger.name.first"
    again = pickle.loads(pickle.dumps(found.value))
    assert (str(again), again.key, again.line) == (str(found.value), "finger.name.first", None)


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -math.inf])
def test_a_number_that_is_not_finite_is_named(case: fre.Case, wrong: float) -> None:
    finger, circle, motion = case.finger, case.object, case.motion
    made: dict[str, Callable[[], object]] = {
        "object.radius_mm": lambda: fre.Case(finger, fre.Circle(wrong, (41.0, 45.0)), motion),
        "object.centre_mm[1]": lambda: fre.Case(finger, fre.Circle(40.0, (41.0, wrong)), motion),
        "motion.motor_angles_deg[1]": lambda: fre.Case(finger, circle, fre.Rotation([1.0, wrong])),
        "motion.times_s[0]": lambda: case.with_motion(fre.Rotation([1.0, 2.0], times_s=[wrong, 1.0])),
        "motion.direction[0]": lambda: fre.Case(finger, circle, fre.Translation((wrong, 0.0), [1.0])),
        "finger.front.thickness_mm": lambda: fre.Case(finger.with_values({"front.thickness_mm": wrong}), circle, motion),
        "finger.lamellae.heights_mm[2]": lambda: fre.Case(
            fre.Finger.parse(finger.with_values({"lamellae.heights_mm.2": wrong}).toml()), circle, motion
        ),
    }
    for key, make in made.items():
        with pytest.raises(fre.CaseError) as error:
            make()
        assert str(error.value) == f"{key} = {wrong}: a finite number is needed"
        assert error.value.key == key


def test_tables_are_the_same_after_toml() -> None:
    table = {
        "name": "mine", "width_mm": 20, "big": 2**70, "is": True, "part": {"list": [[1.0, 2], []], "rows": [{"a": 1}], "none": None}
    }
    expected = {**table, "big": 2.0**70, "part": {"list": [[1.0, 2], []], "rows": [{"a": 1}]}}
    found = fre.Finger.parse(fre.Finger(table).toml()).to_dict()
    assert found == expected and isinstance(found["width_mm"], int) and found["is"] is True
    with pytest.raises(TypeError):
        fre.Finger({"width_mm": object()})


def test_a_preset_that_does_not_exist_is_named() -> None:
    makes: list[Callable[[], object]] = [
        lambda: fre.Case("preset:zz", fre.Circle(40.0, (41.0, 45.0)), fre.Rotation([2.0])),
        lambda: fre.Case.parse('finger = "preset:zz"\n[object]\n[motion]\n'),
    ]
    for make in makes:
        with pytest.raises(fre.CaseError, match="there is no such preset; allowed are \"preset:ladder-80\", ") as error:
            make()
        assert error.value.key == "finger"


def test_a_file_that_is_missing_is_no_fault_of_a_case(tmp_path: pathlib.Path, case: fre.Case) -> None:
    missing = tmp_path / "nope.toml"
    reads: list[Callable[[], object]] = [
        lambda: fre.solve(missing),
        lambda: fre.Case.read(missing),
        lambda: fre.Finger.read(missing),
        lambda: fre.compare(case, missing),
        lambda: fre.calibrate(missing, case),
        lambda: fre.calibrate([missing], missing),
        lambda: fre.read_recording(missing),
    ]
    for read_it in reads:
        with pytest.raises(FileNotFoundError, match="nope.toml"):
            read_it()
    with pytest.raises(OSError):
        fre.solve(tmp_path)
    # The finger that a case names is a key of the case.
    text = case.toml()
    text = f'finger = "{missing}"\n' + text[text.index("[object]") :]
    (tmp_path / "case.toml").write_text(text)
    for read_it in [lambda: fre.Case.parse(text), lambda: fre.Case.read(tmp_path / "case.toml")]:
        with pytest.raises(fre.CaseError, match="nope.toml cannot be read") as error:
            read_it()
        assert error.value.key == "finger"


def test_a_file_with_a_fault_names_line_and_key(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(
        'finger = "preset:ladder-80"\n[object]\nshape = "circle"\nradius_mm = "wide"\ncentre_mm = [41, 45]\n'
        "[motion]\nmotor_angles_deg = [2]\n"
    )
    with pytest.raises(fre.CaseError) as error:
        fre.solve(file)
    assert (error.value.key, error.value.line) == ("object.radius_mm", 4)
    assert str(file) in str(error.value)


@pytest.mark.parametrize(
    ("values", "key"),
    [
        ({"lamellae.gap_mm": 0.5}, "finger.lamellae.gap_mm"),
        ({"material.prony": [[0.6, 0.1], [0.6, 1.0]]}, "finger.material.prony"),
    ],
)
def test_physics_that_is_missing_is_refused_by_name(values: dict[str, object], key: str) -> None:
    finger = fre.Finger.preset("ladder-80").with_values(values)
    with pytest.raises(fre.CaseError) as error:
        fre.Case(finger, fre.Circle(40.0, (41.0, 45.0)), fre.Rotation([2.0]))
    assert error.value.key is not None and error.value.key.startswith(key)


def test_a_finger_is_the_same_as_dictionary_toml_and_file(tmp_path: pathlib.Path) -> None:
    finger = fre.Finger.preset("ladder-80")
    file = tmp_path / "mine.toml"
    file.write_text(finger.toml())
    assert fre.Finger(finger.to_dict()) == fre.Finger.parse(finger.toml()) == fre.Finger.read(file) == finger
    assert finger["hinge.length_mm"] == 2.5 and finger["lamellae.heights_mm.1"] == 18
    thick = finger.with_values({"front.thickness_mm": np.float64(2.5), "lamellae.heights_mm.0": 10})
    assert (thick["front.thickness_mm"], thick["lamellae.heights_mm.0"], finger["front.thickness_mm"]) == (2.5, 10, 2.0)
    with pytest.raises(KeyError):
        finger["front.colour"]
    assert fre.PRESETS == ("ladder-80", "fea-80", "dhas-80", "umi", "vekkax", "hamburg-80")
    with pytest.raises(ValueError, match="not a preset; allowed is ladder-80"):
        fre.Finger.preset("hand")


def test_objects_and_motions_come_back_from_a_case() -> None:
    objects: list[fre.Object] = [
        fre.Circle(40.0, (41.0, 45.0)),
        fre.Ellipse((41.0, 45.0), (30.0, 20.0), 15.0),
        fre.Polygon(((20.0, 30.0), (60.0, 30.0), (60.0, 60.0)), 2.0),
        fre.HalfPlane((12.0, 0.0), (-1.0, 0.0)),
        fre.Bore(200.0, (-150.0, 45.0)),
    ]
    motions: list[fre.Motion] = [fre.Rotation([1.0, 2.5]), fre.Translation((1.0, 0.0), [1.0, 2.0])]
    for thing in objects:
        for motion in motions:
            case = fre.Case("preset:ladder-80", thing, motion)
            assert case.object == thing and case.motion == motion
            assert fre.Case.parse(case.toml()) == case


def test_a_batch_is_the_same_as_one_by_one(case: fre.Case) -> None:
    radii, heights = [30.0, 40.0, 50.0], [40.0, 45.0, 50.0]
    many = fre.solve_many(case, {"object.radius_mm": radii, "object.centre_mm.1": heights})
    for solution, radius, height in zip(many, radii, heights):
        one = fre.solve(case.with_values({"object.radius_mm": radius, "object.centre_mm.1": height}))
        assert without_times(solution.json()) == without_times(one.json())
        assert solution.case == one.case
    # An object around the finger is a status, no exception.
    statuses = [solution.status[-1] for solution in fre.solve_many(case, {"object.radius_mm": [40.0, 200.0, 40.0]})]
    assert [status.name for status in statuses] == ["converged", "out_of_range", "converged"]
    with pytest.raises(fre.CaseError, match="at index 1.*radius_mm") as error:
        fre.solve_many(case, {"object.radius_mm": [40.0, -1.0]})
    assert error.value.key == "object.radius_mm"
    with pytest.raises(fre.CaseError, match="object.radius_mm 2, object.centre_mm.1 3"):
        fre.solve_many(case, {"object.radius_mm": [40.0, 41.0], "object.centre_mm.1": heights})
    with pytest.raises(fre.CaseError) as error:
        fre.solve_many(case, {"object.size": [40.0]})
    assert error.value.key == "object.size"


def test_python_goes_on_while_a_batch_is_solved(case: fre.Case) -> None:
    steps: list[int] = []
    end = threading.Event()

    def count() -> None:
        while not end.is_set():
            steps.append(1)
            time.sleep(1e-4)

    thread = threading.Thread(target=count)
    thread.start()
    before = len(steps)
    fre.solve_many(case, {"object.radius_mm": np.linspace(30.0, 50.0, 64)}, threads=1)
    during = len(steps) - before
    end.set()
    thread.join()
    # With the interpreter held there would be none, or the one that waited.
    assert during > 5


def test_the_first_example_of_the_package_is_true() -> None:
    names = {"fre": fre, "Finger": fre.Finger}
    for module in ("fre", "fre.finger", "fre.optimisation"):
        found = doctest.testmod(importlib.import_module(module), extraglobs=names)
        assert found.failed == 0 and found.attempted > 0, module


def test_a_follower_goes_the_way_of_a_solution(case: fre.Case) -> None:
    follower = fre.Follower(case)
    for place in fre.solve(case):
        found, expected = follower.follow(place.motor_angle_deg).to_dict(), place.to_dict()
        for name in ("elapsed_us", "first_branch"):
            found.pop(name), expected.pop(name)
        assert found == expected
    # Wherever it is sent, and back.
    assert follower.follow(3.3).status is fre.Status.converged
    assert follower.follow(-5.0).status is fre.Status.no_contact
    for wrong in (float("nan"), 181.0):
        with pytest.raises(fre.CaseError) as error:
            follower.follow(wrong)
        assert error.value.key == "to"
    assert pickle.loads(pickle.dumps(follower)).follow(2.0).status is fre.Status.converged


def test_a_material_with_memory_relaxes_in_cases_and_followers() -> None:
    finger = fre.Finger.preset("ladder-80").with_values({"material.prony": [[0.2, 1.0], [0.2, 50.0]]})
    motion = fre.Rotation([6.0, 6.0, 6.0], times_s=[0.0, 1.0, 1000.0])
    case = fre.Case(finger, fre.Circle(40.0, (41.0, 45.0)), motion)
    assert case.motion == motion
    solution = fre.solve(case)
    np.testing.assert_array_equal(solution.time_s, [0.0, 1.0, 1000.0])
    sudden, second, late = solution.force_magnitude_n
    assert late / sudden == pytest.approx(0.6, rel=1e-3)
    assert second / sudden == pytest.approx(1.0 - 0.2 * (1.0 - np.exp(-1.0)) - 0.2 * (1.0 - np.exp(-0.02)), rel=1e-3)
    assert np.isnan(solution.energy_nmm).all() and solution[0].sensitivity is None
    assert "over time" in (solution.svg("force") or "") and "<svg" in (solution.svg("loop") or "")
    # A follower takes the time with every step.
    follower = fre.Follower(case)
    for place, dt_s in zip(solution, (0.0, 1.0, 999.0), strict=True):
        found = follower.follow(6.0, dt_s)
        assert (found.force_magnitude_n, found.time_s) == (place.force_magnitude_n, place.time_s)
    with pytest.raises(fre.CaseError) as error:
        follower.follow(6.0, -1.0)
    assert error.value.key == "dt_s"
    with pytest.raises(fre.CaseError) as error:
        fre.Case(finger, fre.Circle(40.0, (41.0, 45.0)), fre.Rotation([6.0, 6.0], times_s=[1.0, 1.0]))
    assert error.value.key == "motion.times_s[1]"


def test_pictures_of_matplotlib_show_the_solution(case: fre.Case) -> None:
    import matplotlib

    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    from fre import plot

    solution = fre.solve(case)
    ax = plot.force(solution, color="k")
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), solution.force_magnitude_n)
    ax = plot.finger(solution)
    np.testing.assert_array_equal(np.column_stack(ax.lines[0].get_data()), solution[-1].front_mm)
    # The object's outline touches the finger's front, half its thickness away.
    outline = np.column_stack(ax.lines[-1].get_data())
    nearest = min(np.hypot(*(outline - point).T).min() for point in solution[-1].front_mm)
    assert abs(nearest - 1.0) < 0.05
    ax = plot.pressure(solution)
    assert np.size(ax.lines[0].get_xdata()) == len(solution[-1].contact_pressure)
    jaws = fre.Case("preset:ladder-80", fre.Circle(40.0, (41.0, 45.0)), fre.Translation((1.0, 0.0), [1.0, 3.0]))
    assert plot.force(fre.solve(jaws)).get_xlabel() == "distance (mm)"
    plot.finger(fre.solve(jaws), at=1)
    plt.close("all")

"""Sweeps, comparisons and calibrations: what the command writes, as Python has it."""

from __future__ import annotations

import json
import pathlib
import pickle
import signal
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import fre


def columns(csv: str) -> dict[str, list[str]]:
    lines = [line for line in csv.splitlines() if not line.startswith("#")]
    names = lines[0].split(",")
    rows = [line.split(",") for line in lines[1:]]
    return {name: [row[index] for row in rows] for index, name in enumerate(names)}


def test_a_sweep_has_the_columns_and_digits_of_the_command(program: str, case: fre.Case, tmp_path: pathlib.Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(case.toml())
    vary = ["--vary", "object.radius_mm=36,40", "--vary", "elements=24/1,48/2", "--angles", "0:6:2"]
    run = subprocess.run([program, "sweep", file, *vary], capture_output=True, text=True, check=True)
    sweep = fre.sweep(case, {"object.radius_mm": [36.0, 40.0], "elements": ["24/1", "48/2"]}, angles_deg=[0, 2, 4, 6])
    expected = columns(run.stdout)
    assert list(sweep) == list(expected)
    for name, cells in expected.items():
        if name == "elapsed_us":
            continue
        found = sweep[name]
        if isinstance(found, np.ndarray):
            numbers = np.array([float(cell) if cell else np.nan for cell in cells])
            np.testing.assert_array_equal(found, numbers, err_msg=name)
        else:
            words = ["" if value is None else str(value).lower() for value in found]
            assert words == cells, name
    assert sweep.counts["computed"] == 16 and sum(sweep.counts["statuses"].values()) == 16
    assert sweep.status[0] is fre.Status.no_contact
    again = pickle.loads(pickle.dumps(sweep))
    assert again == sweep and again in [sweep] and sweep != fre.Sweep({}, {}) and sweep != dict(sweep)


def test_a_sweep_in_a_file_goes_on_and_can_be_stopped(case: fre.Case, tmp_path: pathlib.Path) -> None:
    out = tmp_path / "sweep.csv"
    radii = np.linspace(35.0, 45.0, 6)

    def stop(checking: bool, done: int, total: int, left_s: float | None) -> None:
        if not checking and done >= 8:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fre.sweep(case, {"object.radius_mm": radii}, out=out, threads=1, progress=stop)
    calls: list[tuple[bool, int, int]] = []
    sweep = fre.sweep(
        case, {"object.radius_mm": radii}, out=out, progress=lambda *told: calls.append((told[0], told[1], told[2]))
    )
    assert sweep.counts["resumed"] >= 8 and sweep.counts["resumed"] + sweep.counts["computed"] == 24
    assert calls[-1] == (False, 24, 24) and len(sweep) == 0
    found = columns(out.read_text())
    assert found["row"] == [str(row) for row in range(24)]
    whole = fre.sweep(case, {"object.radius_mm": radii})
    assert [float(force or "nan") for force in found["force_n"]] == pytest.approx(whole["force_n"].tolist(), rel=0, abs=0, nan_ok=True)
    with pytest.raises(OSError, match="another sweep"):
        fre.sweep(case, {"object.radius_mm": radii[:3]}, out=out)


def test_what_cannot_be_varied_is_named(case: fre.Case) -> None:
    with pytest.raises(ValueError, match="object.radius_mm"):
        fre.sweep(case, {"object.radius": [1.0]})
    with pytest.raises(ValueError, match="at object.radius_mm=-1"):
        fre.sweep(case, {"object.radius_mm": [-1.0]})
    with pytest.raises(ValueError, match="elements"):
        fre.sweep(case, {"elements": ["many"]})


def test_errors_of_a_sweep_have_their_key(case: fre.Case) -> None:
    refused: list[tuple[dict[str, Any], str]] = [
        ({"object.radius": [1.0]}, "object.radius"),
        ({"object.radius_mm": [40.0, -1.0]}, "object.radius_mm"),
        ({"elements": ["many"]}, "elements"),
        ({"object.radius_mm": [30.0, "40"]}, "object.radius_mm"),
        ({"elements": ["24/1", 3.0]}, "elements"),
    ]
    for vary, key in refused:
        with pytest.raises(fre.CaseError) as error:
            fre.sweep(case, vary)
        assert error.value.key == key and error.value.line is None, vary
    with pytest.raises(fre.CaseError, match="object.radius_mm: has numbers and texts \\('40'\\); allowed is one of both"):
        fre.sweep(case, {"object.radius_mm": [30.0, "40"]})  # type: ignore[dict-item]
    with pytest.raises(fre.CaseError) as error:
        fre.sweep(case, {"object.radius_mm": [40.0]}, angles_deg=[500.0])
    assert error.value.key is not None and error.value.key.startswith("motion.motor_angles_deg")


def measurements(case: fre.Case, path: pathlib.Path, factor: float) -> list[float]:
    angles = np.arange(2.0, 10.1, 0.5)
    forces = fre.solve(case.with_motion(fre.Rotation(angles))).force_magnitude_n * factor
    rows = [f"{angle},{force}" for angle, force in zip(angles, forces)]
    path.write_text("motor_angle_deg,force_n\n" + "\n".join(rows) + "\n")
    return [float(angle) for angle in angles]


def test_values_are_any_iterable_and_not_nothing(case: fre.Case) -> None:
    key = "object.radius_mm"
    found = fre.sweep(case, {key: (radius for radius in (39.0, 40.0))}, angles_deg=[4.0])  # type: ignore[dict-item]
    assert found[key].tolist() == [39.0, 40.0]
    with pytest.raises(fre.CaseError, match="has no values"):
        fre.sweep(case, {key: []})
    for threads in (-1, 5000):
        with pytest.raises(fre.CaseError, match=f"threads = {threads}: allowed is 0 to 1024"):
            fre.sweep(case, {key: [39.0]}, threads=threads)
        with pytest.raises(fre.CaseError, match=f"threads = {threads}: allowed is 0 to 1024"):
            fre.solve_many(case, {key: [39.0]}, threads=threads)


def test_a_calibration_finds_what_the_measurements_were_made_with(
    program: str, case: fre.Case, tmp_path: pathlib.Path
) -> None:
    csv, file = tmp_path / "forces.csv", tmp_path / "case.toml"
    # The force is proportional to Young's modulus.
    measurements(case, csv, 1.1)
    file.write_text(case.toml())
    fit = fre.calibrate(csv, case, ["youngs-modulus"])
    modulus = fit.parameter("youngs-modulus")
    assert fit.converged and abs(modulus.value / (1.1 * 49.5) - 1.0) < 1e-3
    assert fit.finger["material.youngs_modulus_pa"] == pytest.approx(1e6 * modulus.value)
    words: list[str | pathlib.Path] = [program, "calibrate", csv, "--case", file, "--fit", "youngs-modulus", "--format", "json"]
    run = subprocess.run(words, capture_output=True, text=True, check=True)
    assert fit.to_dict() == json.loads(run.stdout)
    again = pickle.loads(pickle.dumps(fit))
    assert again.to_dict() == fit.to_dict() and again.text == fit.text and again.svg() == fit.svg()
    assert "<svg" in fit._repr_svg_() and "youngs-modulus 5" in repr(fit)
    with pytest.raises(fre.CaseError) as error:
        fre.calibrate(csv, case, ["colour"])
    assert error.value.key == "fit" and "allowed is youngs-modulus" in str(error.value)
    with pytest.raises(fre.CaseError) as error:
        fre.calibrate(csv, case, noise=fre.Noise(force_sd_n=0.0))
    assert error.value.key == "force_sd_n"
    with pytest.raises(fre.CaseError, match="fit: at least one parameter to fit is needed; allowed is youngs-modulus, ") as error:
        fre.calibrate(csv, case, [])
    assert error.value.key == "fit"
    with pytest.raises(fre.CaseError, match="measurements: at least one file of measurements is needed") as error:
        fre.calibrate([], case)
    assert error.value.key == "measurements"
    assert again == fit and again in [fit] and again.parameters == fit.parameters and fit != fre.calibrate(csv, case, ["zero"])


def test_a_comparison_is_that_of_the_command(program: str, case: fre.Case, tmp_path: pathlib.Path) -> None:
    csv, file = tmp_path / "forces.csv", tmp_path / "case.toml"
    angles = measurements(case, csv, 1.05)
    file.write_text(case.toml())
    comparison = fre.compare(case, csv)
    assert [row.place for row in comparison.rows] == angles
    assert all(abs(row.error_percent - (100.0 / 1.05 - 100.0)) < 1e-6 for row in comparison.rows)
    words: list[str | pathlib.Path] = [program, "compare", file, "--measured", csv, "--format", "json"]
    run = subprocess.run(words, capture_output=True, text=True, check=True)
    found, expected = comparison.to_dict(), json.loads(run.stdout)
    found.pop("model_seconds"), expected.pop("model_seconds")
    assert found == expected
    assert "<svg" in (comparison._repr_svg_() or "")
    assert pickle.loads(pickle.dumps(comparison)) == comparison and comparison in [comparison, fre.Record({})]
    for arguments in ({}, {"measured": csv, "fea": True}):
        with pytest.raises(ValueError, match="either a file of measurements or fea=True"):
            fre.compare(case, **arguments)  # type: ignore[arg-type]


@pytest.mark.skipif(sys.platform == "win32", reason="the program in CalculiX' place is a shell script")
def test_an_interrupt_ends_calculix(case: fre.Case, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ccx = tmp_path / "bin" / "ccx"
    ccx.parent.mkdir()
    ccx.write_text("#!/bin/sh\nexec /bin/sleep 600\n")
    ccx.chmod(0o755)
    monkeypatch.setenv("PATH", str(ccx.parent))
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 1.0)
    try:
        with pytest.raises(KeyboardInterrupt):
            fre.compare(case, fea=True, folder=tmp_path / "files")
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    # A CalculiX that was still there would hold the folder.
    ccx.write_text("#!/bin/sh\nexit 3\n")
    with pytest.raises(OSError, match="reached no place"):
        fre.compare(case, fea=True, folder=tmp_path / "files")


def frame(path: pathlib.Path) -> Any:
    import pandas

    return pandas.read_csv(path) if path.suffix == ".csv" else pandas.read_parquet(path)


def test_pandas_reads_a_sweep_as_it_is_and_parquet_has_the_same(case: fre.Case, tmp_path: pathlib.Path) -> None:
    out, parquet = tmp_path / "sweep.csv", tmp_path / "sweep.parquet"
    vary: dict[str, Any] = {"object.radius_mm": [36.0, 40.0], "elements": ["24/1", "48/2"]}
    sweep = fre.sweep(case, vary, out=out, parquet=parquet, shapes=True)
    assert sweep.counts["computed"] == 16
    csv, columns = frame(out), frame(parquet)
    assert list(csv) == list(columns) and len(csv) == len(columns) == 16
    assert csv["force_n"].dtype == np.float64 and csv["row"].tolist() == list(range(16))
    assert columns["contacts"].dtype == np.int64
    for name in csv:
        if name.endswith("_x_mm") and name.startswith(("front", "back")) or name in ("front_y_mm", "back_y_mm"):
            for text, points in zip(csv[name], columns[name]):
                assert [float(word) for word in text.split()] == points.tolist(), name
        elif csv[name].dtype == np.float64:
            np.testing.assert_array_equal(csv[name], columns[name].astype(np.float64), err_msg=name)
        else:
            assert csv[name].tolist() == columns[name].tolist(), name
    first = fre.solve(case.with_values({"object.radius_mm": 36.0}), fre.Options(elements="24/1"))[1]
    np.testing.assert_array_equal(columns["front_x_mm"][1], first.front_mm[:, 0])
    import pyarrow.parquet

    notes = pyarrow.parquet.read_metadata(parquet).metadata
    assert json.loads(notes[b"fre.sweep"])["rows"] == 16
    with pytest.raises(ValueError, match="parquet needs out"):
        fre.sweep(case, vary, parquet=parquet)


def test_the_command_writes_the_same_parquet(program: str, case: fre.Case, tmp_path: pathlib.Path) -> None:
    file, out, parquet = tmp_path / "case.toml", tmp_path / "rows.csv", tmp_path / "rows.parquet"
    file.write_text(case.toml())
    words: list[str | pathlib.Path] = [program, "sweep", file, "--vary", "object.radius_mm=36,40", "--out", out]
    subprocess.run([*words, "--parquet", parquet], check=True, capture_output=True)
    csv, columns = frame(out), frame(parquet)
    assert list(csv) == list(columns)
    np.testing.assert_array_equal(csv["force_n"], columns["force_n"])
    assert csv["status"].tolist() == columns["status"].tolist()
    # A sweep that is complete is written again, in place of the older file.
    parquet.write_bytes(b"something else")
    subprocess.run([*words, "--parquet", parquet], check=True, capture_output=True)
    assert frame(parquet).equals(columns)


def test_shards_are_merged_into_the_whole(case: fre.Case, tmp_path: pathlib.Path) -> None:
    radii = np.linspace(35.0, 45.0, 5)
    files = [tmp_path / f"{shard}.csv" for shard in (1, 2)]
    for index, file in enumerate(files):
        fre.sweep(case, {"object.radius_mm": radii}, out=file, shard=f"{index + 1}/2")
    whole = fre.sweep(case, {"object.radius_mm": radii}, out=tmp_path / "whole.csv")
    assert whole.counts["computed"] == 20
    assert fre.merge(files[::-1], tmp_path / "merged.csv", parquet=tmp_path / "merged.parquet") == 20
    expected, merged = frame(tmp_path / "whole.csv"), frame(tmp_path / "merged.csv")
    assert merged.drop(columns="elapsed_us").equals(expected.drop(columns="elapsed_us"))
    assert len(frame(tmp_path / "merged.parquet")) == 20
    for parquet in ("other.csv", "other.csv.sweep"):
        with pytest.raises(OSError, match="needs a file of its own"):
            fre.sweep(case, {"object.radius_mm": radii}, out=tmp_path / "other.csv", parquet=tmp_path / parquet)
    with pytest.raises(OSError, match="missing is 2/2"):
        fre.merge(files[:1], tmp_path / "other.csv")
    with pytest.raises(fre.CaseError) as error:
        fre.sweep(case, {"object.radius_mm": radii}, shard="3/2")
    assert error.value.key == "shard"

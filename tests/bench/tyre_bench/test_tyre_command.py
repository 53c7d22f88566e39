"""``bench tyre`` as a user types it."""

import json
from pathlib import Path

import pytest
from rig_tables import true_tyre, write_tables

from bench.cli import main
from vehicle_model.tyres import read_tir
from vehicle_model.tyres.tir_writer import write_tir
from vehicle_model.vehicle_file import TYRES


@pytest.fixture
def tir(tmp_path: Path) -> Path:
    return write_tir(tmp_path / "truth.tir", true_tyre())


def test_list_and_show(capsys: pytest.CaptureFixture[str], tir: Path) -> None:
    assert main(["tyre", "list", "--json"]) == 0
    assert set(json.loads(capsys.readouterr().out)) == {file.stem for file in TYRES.glob("*.yaml")}
    assert main(["tyre", "show", "reduced_set_t:rear", "tmeasy", str(tir), "--json"]) == 0
    rear, tmeasy, magic = json.loads(capsys.readouterr().out)
    assert rear["peak_braking"] == pytest.approx(0.98, rel=1e-4)  # l. 1404: k0R
    assert tmeasy["peak_braking"] == pytest.approx(1.1, rel=1e-3)
    assert magic["formula"] == "Magic Formula 6.1"
    assert magic["slip_stiffness"] == pytest.approx(24.0, rel=1e-3)
    assert main(["tyre", "show", "dugoff", "--load", "4 kN"]) == 0
    assert "4000 N" in capsys.readouterr().out


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_plot(tmp_path: Path, tir: Path, ending: str) -> None:
    out = tmp_path / f"tyres.{ending}"
    tyres = ["lugre"] if ending == "pdf" else ["dugoff", str(tir)]
    assert main(["tyre", "plot", *tyres, "--out", str(out)]) == 0
    assert out.stat().st_size > 5_000


def test_fit_writes_tyre_pictures_and_figures(tmp_path: Path, tir: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_tables(tmp_path)
    tables = [str(tmp_path / name) for name in ("drivebrake.csv", "cornering.csv")]
    options = ["--out", str(tmp_path / "fit"), "--name", "mine", "--radius", "0.3 m", "--compare", str(tir)]
    assert main(["tyre", "fit", *tables, *options, "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((tmp_path / "fit" / "fit.json").read_text("utf-8"))
    for by_force in printed["ratio"].values():  # over the noise: what is compared with is the tyre behind the tables
        assert max(by_force["fx"], by_force["fy"], by_force["mx"]) < 1.1
        assert by_force["mz"] < 1.3
    assert read_tir(tmp_path / "fit" / "mine.tir").record["UNLOADED_RADIUS"][0] == 0.3
    assert {Path(file).name for file in printed["pictures"]} == {"fit.png", "residuals.png"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["show", "tmeasi"], "did you mean tmeasy?"),
        (["show", "tmeasy", "--load", "4 kg"], "--load: wrong dimension"),
        (["plot", "tmeasy", "--out", "a.bmp"], "unknown kind of picture"),
        (["show", "none.tir"], "none.tir: no such file"),
        (["fit", "none.csv"], "none.csv: no such file"),
        (["fit", "none.csv", "--unit", "P"], "no COLUMN=UNIT"),
    ],
)
def test_bad_usage(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tyre", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_check_of_a_tir_file(tmp_path: Path, tir: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(tir)]) == 0
    assert "tyre of the Magic Formula 6.1" in capsys.readouterr().out
    bad = tmp_path / "bad.tir"
    bad.write_text(
        tir.read_text("latin-1")
        .replace("'newton'", "'lbf'")
        .replace("NOMPRES                  = 200000.0", "NOMPRES = 29")
    )
    assert main(["check", str(bad)]) == 2
    error = capsys.readouterr().err
    assert "bad.tir:7:1  FORCE: not an SI unit" in error

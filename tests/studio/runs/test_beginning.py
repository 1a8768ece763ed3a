from scenes import load_scene
from studio.cli import main


def test_a_new_scene_is_written_once(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["--new", "linear"]) == 0
    assert capsys.readouterr().out == "linear.stl.toml\n"
    assert load_scene(tmp_path / "linear.stl.toml").robot == "linear"
    before = (tmp_path / "linear.stl.toml").read_bytes()
    assert main(["--new", "linear"]) == 2
    assert "linear.stl.toml: exists already; give another" in capsys.readouterr().err
    assert (tmp_path / "linear.stl.toml").read_bytes() == before


def test_it_goes_where_it_is_told(tmp_path, capsys):
    path = tmp_path / "mine.stl.toml"
    assert main(["--new", "quadrotor", "--variant", "raw-motors", "--out", str(path)]) == 0
    scene = load_scene(path)
    assert (scene.name, scene.robot, scene.variant) == ("mine", "quadrotor", "raw-motors")
    assert main(["--explain", "--scene", str(path)]) == 0
    assert "Subgoal" in capsys.readouterr().out


def test_what_goes_wrong_is_told(tmp_path, capsys):
    assert main(["--new", "linaer", "--out", str(tmp_path / "a.stl.toml")]) == 2
    assert "unknown 'linaer'" in capsys.readouterr().err
    assert main(["--new", "linear", "--out", str(tmp_path / "missing" / "a.stl.toml")]) == 2
    assert "cannot be written" in capsys.readouterr().err
    assert main(["--new", "linear", "--seed", "3"]) == 2
    assert "--seed cannot be used with --new" in capsys.readouterr().err

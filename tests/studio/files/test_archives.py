import io
import zipfile

import pytest

from core.errors import UserError
from scenes import load_task
from studio.files.archives import LARGEST_UPLOAD, bundle_zip, read_policy_zip
from studio.files.shipped import shipped_policy


@pytest.fixture(scope="module")
def bundle(linear_task, disk_cache):
    policy = shipped_policy(load_task("linear-08"), linear_task)
    assert policy is not None
    return bundle_zip(policy)


def repacked(bundle, rename=lambda name: name, drop=()):
    file = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(bundle)) as old, zipfile.ZipFile(file, "w") as new:
        for name in old.namelist():
            if name not in drop:
                new.writestr(rename(name), old.read(name))
    return file.getvalue()


def test_a_bundle_comes_back(bundle):
    policy = read_policy_zip("mine.zip", bundle)
    assert policy.scene == load_task("linear-08")
    assert (policy.mode, policy.method, policy.seed) == ("studio", "tgpo-star", 1007)


def test_a_zipped_run_has_its_bundle_further_down(bundle):
    nested = repacked(bundle, lambda name: f"runs/x/bundle/{name}")
    assert read_policy_zip("run.zip", nested).scene.name == "linear-08"


def test_names_in_an_archive_never_become_paths(bundle, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = io.BytesIO(bundle)
    with zipfile.ZipFile(file, "a") as archive:
        archive.writestr("../../evil.txt", "evil")
        archive.writestr("/evil.txt", "evil")
    assert read_policy_zip("../../etc/passwd.zip", file.getvalue()).scene.name == "linear-08"
    assert list(tmp_path.rglob("evil*")) == []


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"", "not a zip file"),
        (b"PK\x03\x04 and then nothing", "not a zip file"),
        (bytes(LARGEST_UPLOAD + 1), "larger than"),
    ],
)
def test_what_is_no_archive_is_refused(content, text):
    with pytest.raises(UserError, match=text):
        read_policy_zip("x.zip", content)


def test_incomplete_and_damaged_bundles_are_refused(bundle):
    with pytest.raises(UserError, match=r"weights\.safetensors is missing"):
        read_policy_zip("x.zip", repacked(bundle, drop=("weights.safetensors",)))
    with pytest.raises(UserError, match="no policy bundle"):
        read_policy_zip("x.zip", repacked(bundle, drop=("metadata.json",)))
    file = io.BytesIO(repacked(bundle, drop=("weights.safetensors",)))
    with zipfile.ZipFile(file, "a") as archive:
        archive.writestr("weights.safetensors", b"\x80\x04pickle")
    with pytest.raises(UserError, match=r"^x\.zip"):
        read_policy_zip("x.zip", file.getvalue())

import io
import zipfile

import pytest

from core.errors import UserError
from scenes import load_task
from studio.export.archives import LARGEST_UPLOAD, bundle_zip, read_policy_zip
from studio.runs.pretrained import shipped_weights


@pytest.fixture(scope="module")
def bundle(linear_task, disk_cache):
    weights = shipped_weights(linear_task)
    assert weights is not None
    return bundle_zip(weights.policy(load_task("linear-08")))


def repacked(bundle, rename=lambda name: name, drop=()):
    file = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(bundle)) as old, zipfile.ZipFile(file, "w") as new:
        for name in old.namelist():
            if name not in drop:
                new.writestr(rename(name), old.read(name))
    return file.getvalue()


def test_a_bundle_comes_back(bundle, linear_task):
    policy = read_policy_zip("mine.zip", bundle)
    assert policy.scene == load_task("linear-08")
    weights = shipped_weights(linear_task)
    assert weights is not None
    assert (policy.mode, policy.method, policy.seed) == ("studio", "tgpo", weights.card.seed)


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


def rewritten(bundle, name, data, method=zipfile.ZIP_DEFLATED):
    file = io.BytesIO(repacked(bundle, drop=(name,)))
    with zipfile.ZipFile(file, "a") as archive:
        archive.writestr(name, data, method)
    return file.getvalue()


def flipped(content, place):
    return content[:place] + bytes([content[place] ^ 0xFF]) + content[place + 1 :]


def test_every_kind_of_damage_is_told(bundle):
    """Flipped bits in the directory, in the local headers and in the compressed data."""
    packed = bundle.index(b"weights.safetensors") + 60
    spots = [packed, packed + 1, *range(packed + 2, packed + 2_000, 97)]
    spots += range(bundle.rindex(b"PK\x01\x02") - 400, len(bundle), 5)
    for place in spots:
        try:
            read_policy_zip("x.zip", flipped(bundle, place))
        except UserError as error:
            assert str(error).startswith("x.zip")


def test_what_cannot_be_unpacked_is_named(bundle):
    content = rewritten(bundle, "weights.safetensors", b"x" * 1000, zipfile.ZIP_LZMA)
    with pytest.raises(UserError, match=r"weights\.safetensors is compressed by method 14"):
        read_policy_zip("x.zip", content)
    damaged = bytearray(rewritten(bundle, "weights.safetensors", bytes(range(256)) * 40))
    start = damaged.rindex(b"PK\x03\x04") + 30 + len("weights.safetensors")
    damaged[start : start + 40] = b"\xff" * 40
    with pytest.raises(UserError, match=r"weights\.safetensors cannot be unpacked: "):
        read_policy_zip("x.zip", bytes(damaged))


def test_altered_programs_are_told(bundle):
    with pytest.raises(UserError, match=r"x\.zip: step\.stablehlo is not the file that was saved"):
        read_policy_zip("x.zip", rewritten(bundle, "step.stablehlo", b"other"))


def test_a_directory_of_many_files_is_refused_unread(bundle):
    file = io.BytesIO(bundle)
    with zipfile.ZipFile(file, "a") as archive:
        for number in range(500):
            archive.writestr(f"{number}", b"")
    with pytest.raises(UserError, match="more than 500 files"):
        read_policy_zip("x.zip", file.getvalue())


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

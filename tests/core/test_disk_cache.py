"""Where compiled programs are kept."""

import jax

from core.compilation import use_disk_cache


def test_the_cache_is_the_users_by_the_xdg_standard(tmp_path, monkeypatch):
    monkeypatch.setattr(jax.config, "update", lambda *_: None)  # the tests' own cache stays
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert use_disk_cache() == tmp_path / "cache" / "tgpo-studio" / "jax"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert use_disk_cache() == tmp_path / ".cache" / "tgpo-studio" / "jax"
    assert use_disk_cache(tmp_path / "own") == tmp_path / "own"

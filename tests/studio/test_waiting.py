"""Waiting: a condition that held once has held."""

from tests.studio.waiting import wait_for


def test_what_holds_for_a_moment_only_is_seen():
    values = iter([False, True, False])
    assert wait_for(lambda: next(values))


def test_what_never_holds_is_given_up():
    assert not wait_for(lambda: False, timeout=0.02)

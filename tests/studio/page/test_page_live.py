"""A training that runs while pages come and go: one state for all of them, nothing lost."""

from scenes import load_task
from tests.studio.page.test_page import EDITOR, choose_task, studio, wait_for_text
from tests.studio.waiting import PATIENCE, wait_for

__all__ = ["studio"]

FORMULA = "(F_[0:40](A1) | F_[0:60](A2)) & F_[10:90](A3) & G_[0:100](!B5)"
FIRST, SECOND = "0: F_[0:40](A1)", "1: F_[0:60](A2)"
CRITIC = "critic's choice"
EPOCH = "document.querySelector('.tg-training')?.textContent.match(/(\\d+)epochs/)?.[1]"


def epoch_passes(page, studio):
    """Wait until the page shows an epoch that is later than the one of this moment."""
    now = studio.session.training.epoch
    page.wait_for_function(f"now => Number({EPOCH}) > now", arg=now, polling=100)


def wait_for_axis(page, name):
    """Wait until the map's horizontal axis is that variable."""
    page.locator(f"svg text:has-text('{name} [steps]')").first.wait_for()


def choose_branch(page, shown, name):
    page.locator(f'input[value="{shown}"]:visible').first.click()
    page.get_by_role("option", name=name, exact=True).click()


def test_a_training_outlives_pages_and_is_the_same_on_all(studio, page):
    page.goto(studio.url)
    wait_for_text(page, ".tg-tree", "Reach(φ₀, t2)")
    page.locator(EDITOR).fill(FORMULA)
    wait_for_text(page, ".tg-tree", "A3")
    page.get_by_role("button", name="Train", exact=True).click()
    page.wait_for_selector("image.tg-cells")

    choose_branch(page, CRITIC, FIRST)
    wait_for_axis(page, "t1")
    choose_branch(page, FIRST, SECOND)
    wait_for_axis(page, "t2")

    page.reload()
    wait_for_text(page, ".tg-tree", "A3")
    assert page.locator(EDITOR).input_value() == FORMULA
    epoch_passes(page, studio)
    second = page.context.browser.new_page()
    second.set_default_timeout(1000 * PATIENCE)
    second.goto(studio.url)
    epoch_passes(second, studio)
    assert second.locator(EDITOR).input_value() == FORMULA
    second.locator(f"input[value='{SECOND}']:visible").first.wait_for()

    before = set(studio._server.get_clients())
    studio._server._websock_server.disconnect_all_clients()
    assert wait_for(lambda: len(studio._server.get_clients().keys() - before) == 2)
    epoch_passes(page, studio)
    epoch_passes(second, studio)
    second.close()

    choose_task(page, "linear-07")
    page.wait_for_selector("text=Opening another scene stops")
    page.wait_for_selector("text=Opening another scene discards your unsaved changes")
    page.get_by_role("button", name="Stay here").click()
    page.wait_for_selector("text=Opening another scene stops", state="detached")
    epoch_passes(page, studio)
    assert page.locator(EDITOR).input_value() == FORMULA
    choose_task(page, "linear-07")
    page.get_by_role("button", name="Go anyway").click()
    wait_for_text(page, ".tg-tree", "Reach(A2, t2)")
    assert wait_for(lambda: not studio.session.training.busy)
    assert wait_for(lambda: studio.session.document.scene == load_task("linear-07"))

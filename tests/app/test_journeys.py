"""What a user does with the page, in a real browser, by clicks and keys."""

import re
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest

from hydroservo.scenario import load_scenario
from tests.support.browser import (
    MASS,
    answered,
    enter,
    field,
    open_groups,
    problem,
    served,
    shown,
)
from tests.support.synthetic_logs import exact_log, recorded, with_units

pytestmark = pytest.mark.nightly

GAIN = "controller.controller.controller.proportional_gain"
STEPS = 20  # of a slider


def metric(page, name):
    return page.locator(f"#metrics tr:has(th:text-is('{name}')) td").first.inner_text()


def follows(page):
    """How long run and curve took to follow each step of a slider [s], at the 95th percentile."""
    page.evaluate("performance.clearMeasures()")
    for _ in range(STEPS):
        page.keyboard.press("ArrowRight")
        time.sleep(0.15)
    entries = "(name) => performance.getEntriesByName(name).map((one) => one.duration / 1000)"
    took = [page.evaluate(entries, name) for name in ("follow", "follow-bode")]
    assert min(map(len, took)) > 0
    return [float(np.percentile(one, 95)) for one in took]


def test_plots_follow_a_slider(chromium):
    """A run of 3 s at 1 kHz; how soon is printed, for what else a machine does counts too."""
    scenario = ("rig/1khz-pi-square", "--set", "simulation.duration=3s")
    with served(*scenario) as server, shown(chromium, server.url) as page:
        open_groups(page)
        page.wait_for_selector("#margins dd")
        before = metric(page, "rms error")
        page.locator("[id='slider-controller.proportional_gain']").focus()
        follows(page)  # warm
        print("95th percentiles of run and curve [s]:", follows(page))
        page.wait_for_timeout(1000)
        assert metric(page, "rms error") != before
        assert page.evaluate("performance.getEntriesByName('follow').length") > 0


def test_a_number_without_unit_and_one_out_of_range_are_refused(page):
    for text, said in (("80", "has no unit"), ("-1 kg", "above 0"), ("", "quantity")):
        enter(page, MASS, text)
        page.locator(f"[id='problem-{MASS}']", has_text=said).wait_for()


def test_a_diverging_run_says_so_at_its_field(page):
    enter(page, MASS, "0.1 g")
    page.locator("#notes", has_text="Diverged").wait_for()
    assert "The run diverged" in problem(page, MASS).inner_text()
    page.get_by_role("button", name="Undo").click()
    page.wait_for_selector("#notes:not(.bad)", state="attached")


def test_a_reload_loses_nothing(page):
    enter(page, MASS, "90 kg")
    page.wait_for_selector("#undo:enabled")
    page.get_by_role("button", name="Pin run").click()
    page.reload()
    answered(page)
    open_groups(page)
    assert field(page, MASS).input_value() == "90 kg"
    page.locator("#metrics th", has_text="pin 1").wait_for()
    page.get_by_role("button", name="Undo").click()
    page.locator("#undo:disabled").wait_for()
    page.wait_for_timeout(500)
    assert field(page, MASS).input_value() == "160 kg"


def test_two_tabs_do_not_disturb_each_other(page, chromium, server):
    with shown(chromium, server.url) as other:
        open_groups(other)
        enter(page, MASS, "90 kg")
        enter(other, MASS, "300 kg")
        for one in (page, other):
            one.wait_for_selector("#undo:enabled")
            answered(one)
        assert field(page, MASS).input_value() == "90 kg"
        assert field(other, MASS).input_value() == "300 kg"
        other.wait_for_timeout(500)
        assert metric(page, "rms error") != metric(other, "rms error")


def test_a_killed_server_is_said_and_the_page_goes_on_with_the_next(chromium):
    with served("axis/position") as first:
        port = first.port
        with shown(chromium, first.url) as page:
            open_groups(page)
            first.process.kill()
            first.process.wait()
            enter(page, MASS, "90 kg")
            page.locator("#banner", has_text="The server has ended").wait_for()
            with served("axis/position", "--port", str(port)):
                page.locator("#banner").wait_for(state="hidden")
                answered(page)
                assert field(page, MASS).input_value() == "90 kg"


def test_another_law_and_demand_are_chosen_and_compared(page):
    page.get_by_role("button", name="Pin run").click()
    page.locator("[id='type-reference']").select_option("Sine")
    needed = page.locator("[id='needed-reference'] input")
    needed.first.wait_for()
    for one in needed.all():
        one.fill("0.5 Hz" if "frequency" in one.get_attribute("id") else "40 mm")
    page.get_by_role("button", name="Take it").click()
    page.locator("[id='field-reference.frequency']").wait_for()
    page.locator("[id='type-controller']").select_option("PID")
    page.locator("[id='field-controller.proportional_gain']").wait_for()
    answered(page)
    assert page.locator("#metrics thead th").count() == 3
    page.get_by_role("button", name="Go back to pin 1").click()
    page.locator(f"[id='field-{GAIN}']").wait_for(state="attached")


def test_a_scenario_is_saved_and_opened_again(page, tmp_path):
    enter(page, MASS, "90 kg")
    page.wait_for_selector("#undo:enabled")
    with page.expect_download() as waiting:
        page.get_by_role("button", name="Save TOML").click()
    file = tmp_path / waiting.value.suggested_filename
    waiting.value.save_as(file)
    assert tomllib.loads(file.read_text())["base"] == "axis/position"
    assert load_scenario(file) == load_scenario("axis/position", {MASS: 90.0})
    page.get_by_role("button", name="Undo").click()
    page.locator("#open").set_input_files(file)
    page.locator("#scenario option:checked", has_text="opened file").wait_for(state="attached")
    page.wait_for_timeout(800)
    assert field(page, MASS).input_value() == "90 kg"
    wrong = tmp_path / "wrong.toml"
    wrong.write_text('base = "axis/position"\n[plant.mechanism]\nmas = "1 kg"\n')
    page.locator("#open").set_input_files(wrong)
    page.locator("#problem", has_text="did you mean mass").wait_for()


def test_long_work_shows_progress_and_can_be_stopped(page):
    page.locator("#export").select_option("c")
    page.locator("#work").wait_for()
    page.get_by_role("button", name="Stop").click()
    page.locator("#work").wait_for(state="hidden")
    enter(page, MASS, "91 kg")
    answered(page)
    with page.expect_download(timeout=60_000) as waiting:
        page.locator("#export").select_option("c")
    assert Path(waiting.value.path()).read_bytes()[:2] == b"PK"


def test_a_log_is_drawn_and_tells_numbers(page, tmp_path):
    import pandas as pd

    log = tmp_path / "bench.csv"
    rows = with_units(recorded(exact_log(), 0))
    rows["velocity [m/s]"][700] = 4.1
    pd.DataFrame(rows).to_csv(log, index=False)
    page.locator("#scenario").select_option("rig/1khz-pi-square")
    page.wait_for_selector("#undo:enabled")
    answered(page)
    page.locator("#log-file").set_input_files(log)
    page.locator("#log h2", has_text="bench.csv").wait_for()
    page.locator("#replay", has_text="recorded command drives the scenario's machine").wait_for()
    assert "log, replay" in page.locator("#log-plots canvas").nth(1).get_attribute("aria-label")
    assert page.locator("#log figcaption:visible", has_text="1 sample up to 4100 mm/s").count() == 1
    page.locator("#seek").select_option("plant.mass")
    usual = page.locator("[id='seek-plant.mass']").input_value()
    page.locator("[id='seek-plant.mass']").fill("3..9")
    page.get_by_role("button", name="Identify").click()
    page.locator("[id='sought-plant.mass']", has_text="3..9 has no unit: 3..9 kg?").wait_for()
    page.locator("[id='seek-plant.mass']").fill(usual)
    page.get_by_role("button", name="Identify").click()
    page.get_by_role("button", name="Take these numbers").wait_for()
    assert page.locator("#found td").count() >= 3
    page.get_by_role("button", name="Take these numbers").click()
    answered(page)


def test_all_is_done_by_keys_alone(page):
    page.locator("#find").focus()
    page.keyboard.type("mass")
    page.locator("[id='field-plant.mechanism.mass']").wait_for()
    page.get_by_role(
        "button", name="Proportional directional valve, SecondOrderValve: show its parameters"
    ).focus()
    page.keyboard.press("Enter")
    assert page.evaluate("document.activeElement.id || document.activeElement.tagName") == "type-valve"
    page.locator("#instant").focus()
    before = page.locator("#instant-text").inner_text()
    page.keyboard.press("ArrowRight")
    assert page.locator("#instant-text").inner_text() != before


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [(1440, 900), (390, 844)])
def test_nothing_keeps_anyone_out(chromium, server, scheme, size):
    from axe_playwright_python.sync_playwright import Axe

    width, height = size
    looks = {"viewport": {"width": width, "height": height}, "color_scheme": scheme, "bypass_csp": True}
    with shown(chromium, server.url, **looks) as page:
        page.wait_for_selector("#margins dd")
        page.get_by_role("button", name="Pin run").click()
        open_groups(page)
        found = Axe().run(page).response["violations"]
        serious = [one for one in found if one["impact"] in ("serious", "critical")]
        assert [(one["id"], [node["html"] for node in one["nodes"]][:3]) for one in serious] == []
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_another_site_in_the_same_browser_is_refused(chromium, server):
    with shown(chromium, server.url) as page:
        page.route("http://other.test/**", lambda route: route.fulfill(body="elsewhere"))
        page.goto("http://other.test/")
        asked = f"fetch('{server.url}api/job/run', {{method: 'POST', body: '{{}}', mode: 'no-cors'}})"
        assert page.evaluate(f"{asked}.then((one) => one.type, () => 'refused')") in ("opaque", "refused")
        read = f"fetch('{server.url}api/begin').then((one) => one.text(), () => 'refused')"
        assert page.evaluate(read) == "refused"


def test_the_circuit_follows_the_run(page):
    """At rest the spool is in the middle; on the way out it is parallel, and the piston further on."""

    def moved(instant):
        page.evaluate("([at]) => { document.getElementById('instant').value = at; }", [instant])
        page.locator("#instant").dispatch_event("input")
        spool = page.evaluate("document.querySelector('#drawing [data-switch]').style.transform")
        piston = page.locator("#drawing [data-slide]").first.get_attribute("transform")
        return [float(re.search(r"\(([-.\d]+)", text)[1]) for text in (spool, piston)]

    (rest, start), (out, further) = moved(10), moved(300)
    assert (rest, out) == (0.0, 40.0)
    assert further > start + 10.0
    assert page.locator("#drawing [data-signal='plant.pressure_a']").text_content().endswith(" bar")
    share = (
        "(port) => document.querySelector(`#drawing polyline[data-port=${port}]`)"
        ".style.getPropertyValue('--share')"
    )
    tank, chamber, supply = (float(page.evaluate(share, port)) for port in ("pT", "pA", "pP"))
    assert tank < chamber < supply == 1.0

"""The page against a console that says what a test says: what no real cell says at will."""

import re

import pytest
from playwright.sync_api import expect

import mock
from conftest import DESKTOP, LANDSCAPE, PHONE, PORTRAIT

SIZES = {"desktop": DESKTOP, "portrait": PORTRAIT, "landscape": LANDSCAPE, "phone": PHONE}

# The least ratio of the contrast of each text to what is behind it, and the text.
CONTRAST = """() => {
  const numbers = (colour) => colour.match(/[\\d.]+/g).map(Number);
  const light = (colour) => {
    const [r, g, b] = colour.slice(0, 3).map((part) => part / 255).map((part) => part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const behind = (element) => {
    for (let at = element; at; at = at.parentElement) {
      const colour = numbers(getComputedStyle(at).backgroundColor);
      if (colour.length === 3 || colour[3] > 0) return colour;
    }
    return [255, 255, 255];
  };
  const texts = [...document.querySelectorAll('body *')].filter((element) =>
    element.checkVisibility() && [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim()) && !element.closest('[disabled], .unseen, .skip'));
  return texts.map((element) => {
    const style = getComputedStyle(element);
    const [one, other] = [light(numbers(element.closest('svg') ? style.fill : style.color)), light(behind(element))];
    return [(Math.max(one, other) + 0.05) / (Math.min(one, other) + 0.05), element.textContent.trim().slice(0, 40)];
  }).sort((a, b) => a[0] - b[0])[0];
}"""

# What can be touched and is smaller than a finger: a label counts with its box.
SMALL = """() => [...document.querySelectorAll('button, select, input')].filter((element) => element.checkVisibility()).map((element) => {
  const box = (element.closest('label') ?? element).getBoundingClientRect();
  return [element.textContent || element.id, Math.round(box.width), Math.round(box.height)];
}).filter(([, width, height]) => width < 44 || height < 44)"""


@pytest.fixture
def packing(console):
    made = mock.Packing(console)
    made.pack(7)
    made.decide()
    return made


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_fits_screens_of_all_sizes_and_can_be_read_and_touched(console, packing, open_page, picture, scheme):
    page = open_page(console.url, color_scheme=scheme, has_touch=True)
    expect(page.locator("#waiting li")).not_to_have_count(0)
    expect(page.locator("#scene")).to_have_attribute("data-bodies", "7")
    for size, viewport in SIZES.items():
        page.set_viewport_size(viewport)
        picture(page, f"page-{size}-{scheme}")
        assert page.evaluate("document.documentElement.scrollWidth") <= viewport["width"], size
        assert page.evaluate(SMALL) == [], size
        ratio, text = page.evaluate(CONTRAST)
        assert ratio >= 4.5, f"{size}: {text!r} has a contrast of {ratio:.2f}"
        page.mouse.wheel(0, 5000)
        expect(page.get_by_role("button", name="HOLD")).to_be_in_viewport()
        page.evaluate("scrollTo(0, 0)")


def test_everything_that_can_be_used_has_a_name(console, packing, open_page):
    page = open_page(console.url)
    expect(page.locator("#inside tr")).to_have_count(7)
    for region in (
        "What the cell does",
        "Container",
        "From above",
        "Last decision",
        "Waiting",
        "Filled",
        "Cycle times",
        "In the container",
        "Services",
        "Events",
    ):
        expect(page.get_by_role("region", name=region, exact=True)).to_be_visible()
    expect(page.get_by_role("img", name="cell-1 in three dimensions: 7 items; gelatin box is placed next")).to_be_visible()
    snapshot = page.locator("body").aria_snapshot()
    nameless = re.findall(r"- (?:button|combobox|checkbox|textbox|img|region|dialog)(?: \[[^\]]*\])*:?$", snapshot, re.MULTILINE)
    assert nameless == [], snapshot
    expect(page.locator("#announced")).to_contain_text("Placing")


def test_names_from_a_cell_are_text_and_change_nothing_else(console, packing, open_page):
    hostile = '<img src=x onerror="document.body.dataset.broken=1">\u202e</script>' + "W" * 200
    packing.decisions[0]["object"] = packing.items[0]["object"] = hostile
    packing.say("error", "failed", hostile)
    packing.publish("failed", hostile, hostile, [])
    page = open_page(console.url, PHONE)
    expect(page.locator("#said")).to_contain_text("<img src=x")
    expect(page.locator("#happened li").first).to_contain_text("</script>WWW")
    assert "\u202e" not in page.locator("body").inner_text()
    assert page.locator("body[data-broken], main img").count() == 0
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    expect(page.get_by_role("button", name="HOLD")).to_be_in_viewport()


def test_hundreds_of_items_are_shown(console, packing, open_page):
    many = [packing.items[at % 7] | {"item_id": f"many-{at}", "step": at} for at in range(300)]
    console.publish("items", many, mock.CELL, mock.CELL)
    listed = [
        {
            "item_id": f"w-{at}",
            "object": "mug",
            "state": "waiting",
            "is_choosable": at < 5,
            "shape": packing.shape["mug"],
            "order": "",
            "is_fragile": False,
            "is_bottom_only": False,
            "is_upright": False,
            "carries_kg": None,
        }
        for at in range(64)
    ]
    console.publish("buffer", {"limit": 5, "more": 236, "items": listed}, mock.CELL)
    page = open_page(console.url)
    expect(page.locator("#inside tr")).to_have_count(300)
    expect(page.locator("#waiting li")).to_have_count(65)
    expect(page.locator("#waiting li").last).to_have_text("and 236 items more")
    expect(page.locator("#inside-count")).to_have_text("300 items")


def test_what_is_old_is_said_to_be_and_comes_back_by_itself(console, packing, open_page, picture):
    page = open_page(console.url)
    contact = page.locator("#contact")
    expect(contact).to_have_text("Live")
    console.is_silent = True
    expect(page.locator("#said")).to_contain_text("No contact with the console")
    console.is_silent = False
    expect(contact).to_have_text("Live")
    packing.publish("unknown", "Nothing is heard.", "Look at the planner.", ["The planner has not answered for 12 s."])
    expect(page.locator("#said")).to_have_text("The planner has not answered for 12 s.")
    expect(page.locator("#advice")).to_contain_text("Look at the planner.")
    expect(contact).to_have_text("Not current")
    # What grows each second is not read out each second.
    read = page.locator("#announced").inner_text()
    packing.publish("unknown", "Nothing is heard.", "Look at the planner.", ["The planner has not answered for 13 s."])
    expect(page.locator("#said")).to_contain_text("13 s")
    assert page.locator("#announced").inner_text() == read
    for age_s in (12, 13):
        packing.publish("unknown", "Nothing is heard.", "", [f"The picture of cell-1 shows what was there {age_s} s ago."])
        expect(page.locator("#said")).to_contain_text(f"{age_s} s ago")
        expect(page.locator("#announced")).to_have_text("The picture of cell-1 shows what was there.")
    picture(page, "page-stale")
    console.end_streams()
    packing.publish("planning", "Planning.")
    expect(page.locator("#said")).to_have_text("Planning.")


def test_a_cell_of_which_nothing_was_seen_shows_nothing_of_another(console, packing, open_page):
    console.publish("cells", [{"name": "cell-1", "containers": ["cell-1"]}, {"name": "cell-2", "containers": ["cell-2-a", "cell-2-b"]}])
    page = open_page(console.url)
    expect(page.locator("#inside tr")).to_have_count(7)
    page.get_by_role("combobox", name="Cell").select_option("cell-2")
    expect(page.locator("#said")).to_have_text("Nothing was heard of this cell yet")
    expect(page.locator("#scene")).to_be_hidden()
    expect(page.locator("#above")).to_be_hidden()
    expect(page.locator("#inside tr")).to_have_count(0)
    page.get_by_role("combobox", name="Container").select_option("cell-2-b")
    page.reload()
    expect(page.get_by_role("combobox", name="Container")).to_have_value("cell-2-b")
    page.goto("about:blank")
    page.goto(f"{console.url}#%")
    expect(page.locator("#inside tr")).to_have_count(7)


def test_what_cannot_be_drawn_is_left_out(console, packing, open_page):
    """Shapes and heights that are none, an item without a shape, parts that are not there yet."""
    for content in (b"", b"\1\0\0\0\1\0\0\0", b"\1\0\0\0\1\0\0\0" + bytes(12) + b"\7\0\0\0" * 3):
        packing.items.append(packing.items[0] | {"item_id": f"item-{len(content)}-bytes", "shape": f"{len(content):064}"})
        console.shapes[f"{len(content):064}"] = content
    packing.items[0] = packing.items[0] | {"shape": None, "container_from_shape": None, "step": None, "inspection": None}
    packing.publish("planning", "Planning.")
    for part in ("session", "buffer", "cycles", "decisions"):
        console.publish(part, None, mock.CELL)
    page = open_page(console.url)
    expect(page.locator("#inside tr")).to_have_count(10)
    whole = console.parts[(mock.CELL, mock.CELL, "heightmap")]["value"]
    for broken in ("no base64!", "AAAA"):
        console.publish("heightmap", whole | {"heights": broken}, mock.CELL, mock.CELL)
    console.publish("heightmap", None, mock.CELL, mock.CELL)
    expect(page.locator("#nothing-seen")).to_be_visible()
    expect(page.locator("#said")).to_have_text("Planning.")


def test_a_page_that_fails_says_so(console, packing, browser):
    page = browser.new_page()
    page.goto(console.url)
    expect(page.locator("#contact")).to_have_text("Live")
    console.publish("events", [{"number": 1}], mock.CELL)
    expect(page.locator("#said")).to_contain_text("This page has a fault")
    page.close()


def test_without_a_token_there_are_no_controls(open_page):
    with mock.Console(controls=False) as console:
        mock.Packing(console)
        page = open_page(console.url)
        expect(page.locator("#off")).to_contain_text("Watching only")
        expect(page.get_by_role("button", name="HOLD")).to_be_disabled()
        expect(page.get_by_role("button", name="Unlock controls")).to_be_hidden()
        page.keyboard.press("h")
        assert console.asked == []


def test_each_control_is_asked_for_as_the_console_wants_it(console, packing, open_page):
    packing.held = "a door is open"
    packing.publish("held", "Held: a door is open.", "Look, say what changed, and resume.")
    page = open_page(console.url)
    page.get_by_role("button", name="Unlock controls").click()
    page.get_by_label("Token of this console").fill("no tøken")
    page.keyboard.press("Enter")
    expect(page.get_by_role("alert")).to_have_text("That is not the token.")
    page.get_by_label("Token of this console").fill("another-token")
    page.keyboard.press("Enter")
    expect(page.get_by_role("alert")).to_have_text("That is not the token.")
    page.get_by_label("Token of this console").fill(mock.TOKEN)
    page.keyboard.press("Enter")
    expect(page.get_by_role("button", name="Lock controls", exact=True)).to_be_visible()
    dialog = page.get_by_role("dialog")

    def asked(button, *answers, action, **fields):
        console.asked.clear()
        page.locator("#reply").evaluate("(reply) => { reply.textContent = ''; }")
        page.get_by_role("button", name=button, exact=True).first.click()
        for answer in answers:
            dialog.get_by_text(answer, exact=True).click()
        expect(page.locator("#reply")).to_have_text(f"{action}: done.")
        assert console.asked[-1] == (action, {"cell": "cell-1"} | fields)

    for button, action in (("Resume", "resume"), ("Step", "step"), ("New container", "new_container")):
        extra = {"container": "cell-1"} if action == "new_container" else {"hold_ids": ["h1"]}
        asked(button, button, action=action, confirmed=True, **extra)
        assert [fields.get("confirmed") for _, fields in console.asked] == [None, True], console.asked
    asked("I had my hand in it", "Yes, see it anew", action="touched", container="cell-1")
    asked("Item removed", "mug (item-7)", "These were taken out", action="removed", container="cell-1", item_ids=["item-7"])
    asked("bottle item-6 was removed", "These were taken out", action="removed", container="cell-1", item_ids=["item-6"])
    page.get_by_role("button", name="Abort").click()
    page.get_by_role("button", name="Resume", exact=True).click()
    expect(dialog).to_contain_text("Is nobody in the cell?")
    before = len(console.asked)
    page.keyboard.press("Enter")
    expect(dialog).to_be_hidden()
    assert len(console.asked) == before, "Enter does not move a robot by itself"


def test_what_ends_is_what_the_page_showed_when_it_was_asked_for(console, packing, open_page):
    packing.held = "a door is open"
    packing.publish("held", "Held: a door is open.")
    page = open_page(console.url)
    page.evaluate(f"sessionStorage.setItem('ppnpack-console-token', '{mock.TOKEN}')")
    page.reload()
    page.get_by_role("button", name="Resume", exact=True).click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("Is nobody in the cell?")
    # Somebody else holds it while the question is open.
    packing.holds = ["h1", "h2"]
    packing.publish("held", "Held: a door is open; a hand is in the cell.")
    expect(page.locator("#said")).to_contain_text("a hand is in the cell")
    dialog.get_by_role("button", name="Resume", exact=True).click()
    expect(page.locator("#reply")).to_have_text("resume: done.")
    assert console.asked[-1] == ("resume", {"cell": "cell-1", "hold_ids": ["h1"], "confirmed": True})
    packing.held, packing.failure_id = None, "s-1"
    packing.publish("failed", "Stopped: it was lost.")
    page.get_by_role("button", name="I have looked: go on", exact=True).click()
    dialog.get_by_role("button", name="Go on", exact=True).click()
    expect(page.locator("#reply")).to_have_text("automatic: done.")
    assert console.asked[-1] == ("automatic", {"cell": "cell-1", "is_on": True, "failure_id": "s-1", "confirmed": True})


def test_a_question_that_takes_the_place_of_another_one_is_answered(console, packing, open_page):
    packing.held = "a door is open"
    packing.publish("held", "Held: a door is open.", "Look, say what changed, and resume.")
    page = open_page(console.url)
    page.evaluate(f"sessionStorage.setItem('ppnpack-console-token', '{mock.TOKEN}')")
    page.reload()
    page.get_by_role("button", name="I had my hand in it").click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("A hand was in the container")
    page.keyboard.press("s")
    expect(dialog).to_contain_text("Is nobody in the cell?")
    dialog.get_by_role("button", name="Step", exact=True).click()
    expect(page.locator("#reply")).to_have_text("step: done.")
    assert [action for action, _ in console.asked] == ["step", "step"]


def test_what_a_control_came_to_is_said(console, packing, open_page):
    page = open_page(console.url)
    page.evaluate(f"sessionStorage.setItem('ppnpack-console-token', '{mock.TOKEN}')")
    page.reload()
    console.answers["hold"] = (504, {"error": "unanswered", "text": "The bridge did not answer in time.", "question": None})
    expect(page.get_by_role("button", name="HOLD")).to_be_enabled()
    page.keyboard.press("h")
    expect(page.locator("#reply")).to_have_text("Hold may have been done, or not: The bridge did not answer in time.")
    console.answers["hold"] = (429, {"error": "busy", "text": "too many controls are under way", "question": None})
    page.keyboard.press("h")
    expect(page.locator("#reply")).to_have_text("Hold was refused: too many controls are under way")
    console.is_over = True
    page.get_by_role("button", name="HOLD").click()
    expect(page.locator("#reply")).to_contain_text("use the cell's own stop")


def test_an_item_means_one_place_and_is_chosen_in_the_picture(console, packing, open_page):
    packing.publish("planning", "Planning.")
    page = open_page(console.url)
    page.evaluate(f"sessionStorage.setItem('ppnpack-console-token', '{mock.TOKEN}')")
    page.reload()
    expect(page.locator("#scene")).to_have_attribute("data-bodies", "7")
    # The lowest corner of its box, as the decision that placed it had it.
    decided = next(decision for decision in packing.decisions if decision["item_id"] == packing.items[-1]["item_id"])
    x, y, z = (f"{100 * side:.1f} cm" for side in decided["corner_m"])
    expect(page.locator(f"#inside tr[data-item={decided['item_id']}]")).to_contain_text(f"x {x}, y {y}, {z} above the floor")
    box = page.locator("#scene").bounding_box()
    chosen = None
    for at in range(1, 20):
        page.mouse.click(box["x"] + box["width"] * at / 20, box["y"] + box["height"] * 0.6)
        if found := re.search(r"item-\d+", page.locator("#scene-note").inner_text()):
            chosen = found.group()
            break
    page.get_by_role("button", name="Item removed", exact=True).click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("Of 7 items in cell-1")
    expect(dialog.locator(".swatch")).to_have_count(7)
    expect(dialog.locator(f"input[value={chosen}]")).to_be_checked()
    expect(dialog.locator("input:checked")).to_have_count(1)


def test_what_is_not_known_of_the_volume_is_a_gap_and_a_decision_given_up_is_said_to_be(console, packing, open_page):
    packing.held = "a door is open"
    packing.decisions[0]["is_given_up"] = True
    packing.history[-2][1] = None
    packing.publish("held", "Held: a door is open.")
    session = console.parts[(mock.CELL, None, "session")]["value"]
    console.publish("session", session | {"pending": None}, mock.CELL)
    page = open_page(console.url)
    expect(page.locator("#last")).to_contain_text("given up: it is not carried out")
    line = page.locator("#filled .line").get_attribute("d")
    assert line.count("M") == 2 and "null" not in line and "NaN" not in line, line


def test_letters_act_only_where_they_may(console, packing, open_page):
    page = open_page(console.url)
    page.evaluate(f"sessionStorage.setItem('ppnpack-console-token', '{mock.TOKEN}')")
    page.reload()
    page.get_by_role("button", name="Keys").click()
    page.get_by_label("Letters act").uncheck()
    page.get_by_role("button", name="Close", exact=True).click()
    page.keyboard.press("h")
    page.get_by_role("button", name="Keys").click()
    page.get_by_label("Letters act").check()
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Lock controls", exact=True).click()
    page.get_by_role("button", name="Unlock controls").click()
    page.get_by_label("Token of this console").press_sequentially("hhh")
    assert console.asked == []
    page.keyboard.press("Escape")


def test_the_theme_is_kept(console, packing, open_page):
    page = open_page(console.url, color_scheme="light")
    ground = "getComputedStyle(document.body).backgroundColor"
    light = page.evaluate(ground)
    page.get_by_role("button", name="Theme: automatic").click()
    assert page.evaluate(ground) != light
    page.reload()
    expect(page.get_by_role("button", name="Theme: dark")).to_be_visible()
    assert page.evaluate(ground) != light


def test_the_picture_is_turned_and_items_are_named_in_it(console, packing, open_page):
    page = open_page(console.url)
    scene = page.locator("#scene")
    expect(scene).to_have_attribute("data-bodies", "7")
    seen = scene.screenshot()
    scene.focus()
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("+")
    turned = scene.screenshot()
    assert turned != seen
    page.keyboard.press("0")
    box = scene.bounding_box()
    for at in range(1, 20):
        page.mouse.click(box["x"] + box["width"] * at / 20, box["y"] + box["height"] * 0.6)
        if "item-" in page.locator("#scene-note").inner_text():
            break
    expect(page.locator("#scene-note")).to_contain_text("item-")
    page.locator("#above").focus()
    page.keyboard.press("ArrowUp")
    expect(page.locator("#above-note")).to_have_text(re.compile(r"x 16\.\d cm, y 17\.\d cm: \d+\.\d cm high"))

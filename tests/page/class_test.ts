// A course on the page, in a real browser at a gateway that does what a test says.
import {expect} from "vitest";

import {
  appears,
  atGatewayUnseen,
  chooseLanguage,
  gateway,
  move,
  open,
  page,
  reads,
  startGateway,
  text,
} from "./support/at_gateway";
import {eventually, probe, until} from "./support/browser";
import {heldExam, kExercise, ownExam, ownTurn, trialState} from "./support/exam_state";
import {pressed, sessionState} from "./support/fake_gateway";
import {kTestScene} from "./support/scene_bytes";
import {browserTest as test} from "./support/skip";

const kSeat = {...kTestScene, name: `${kTestScene.name}-1`};

atGatewayUnseen(kTestScene, kSeat);

const person = (id: number, name: string, more: object = {}): object => ({
  ...{person: id, name, role: "drive", station: name, here: 1, seat: ""},
  ...more,
});
const tellPeople = (...people: object[]): void =>
  gateway.retain("/palpate/people", {scene: "", people});
const card = (name: string) =>
  page.locator(".wall li").filter({has: page.locator("b", {hasText: name})});
const press = (name: string): Promise<void> =>
  page.getByRole("button", {name, exact: true}).click();

/// A teacher's page with the class open, at a gateway that answers with `people`.
async function openClass(answer: object): Promise<void> {
  gateway.role = "operate";
  gateway.hasCourse = true;
  gateway.onPublish = ({tag}) => {
    const usual = {tag, refusal: "", note: "", people: []};
    if (tag !== undefined) gateway.send("/palpate/class_answer", {...usual, ...answer});
  };
  await open();
  await press("Class");
}

test("a teacher pastes names and has a link and a QR code for each, once", async () => {
  const made = ["Anna", "Ben"].map((name, i) => ({person: i + 2, name, token: `palpate_${name}`}));
  tellPeople(person(1, "teacher", {role: "operate"}));
  await openClass({people: made});
  await page.fill("#class-names", " Anna \n\nBen\n");
  await press("Make their links");
  await page.locator(".link-cards li").nth(1).waitFor();
  expect(gateway.published).toEqual([
    {tag: 1, op: "person_make", names: ["Anna", "Ben"], role: "drive"},
  ]);
  expect(await page.locator(".link-cards a").allInnerTexts()).toEqual(
    made.map(({token}) => `${gateway.url}#token=${token}`),
  );
  await page.getByRole("img", {name: "QR code of Ben's link"}).waitFor();
  await press("Close");
  await press("Class");
  expect(await page.locator(".link-cards li").count()).toBe(0);
});

test("names found in a table are shown before their links are made, 200 at once", async () => {
  tellPeople(person(1, "teacher", {role: "operate"}));
  await openClass({people: [{person: 2, name: "Anna Weber", token: "palpate_a"}]});
  await page.fill("#class-names", "Name;Vorname;Mail\nWeber;Anna;a@b.de\nMüller;Zoë;z@b.de");
  await press("Make their links");
  await reads(".found", /2 names found/);
  expect(await page.inputValue("#class-names")).toBe("Anna Weber\nZoë Müller");
  expect(gateway.published).toEqual([]);
  const many = Array.from({length: 450}, (_, i) => `Student ${i}`);
  await page.fill("#class-names", many.join("\n"));
  await press("Make their links");
  await eventually("three wishes", () => gateway.published.length === 3);
  const wishes = gateway.published as {names: string[]}[];
  expect(wishes.flatMap(({names}) => names)).toEqual(many);
  await eventually("all links", async () => (await page.locator(".link-cards li").count()) === 3);
  expect(await page.inputValue("#class-names")).toBe("");
});

test("people are called by their names, and exercises by their titles, never by a station's", async () => {
  const title = {en: "Light force", de: "Leichte Kraft"};
  const trial = {
    ...{exercise: "light-force", title, n: 2, phase: "scored"},
    ...{ahead: 0, reason: "", points: 81},
  };
  gateway.retain("/palpate/people", {
    scene: "",
    people: [person(2, "王伟", {station: "wang_wei", trial})],
  });
  const me = {person: 1, name: "teacher", role: "operate", seat: "", line: "", lines: 0};
  gateway.retain("/palpate/me", {...me, names: {Eva_Muller_7: "Eva Müller"}});
  for (const station of ["wang_wei", "Eva_Muller_7"])
    gateway.retain(
      "/palpate/session_state",
      sessionState(station, "active", kTestScene.name, "ball"),
    );
  move((sequence) => gateway.send("/palpate/tool_state", pressed("wang_wei", sequence, 2)));
  await openClass({});
  await eventually("both", async () => (await page.locator(".wall b").count()) === 2);
  expect((await page.locator(".wall b").allInnerTexts()).sort()).toEqual(["Eva Müller", "王伟"]);
  expect(await card("王伟").innerText()).toMatch(/Light force, trial 2/);
  await press("Close");
  await eventually("the console", async () => (await page.locator("#console b").count()) === 2);
  const shown = await page.evaluate(() => document.body.innerText);
  expect(shown).not.toMatch(/wang_wei|Eva_Muller|light-force/);
  expect((await page.locator("#station option").allInnerTexts()).sort()).toEqual([
    "Eva Müller",
    "王伟",
  ]);
});

test("a refusal is told in the gateway's words, and who is withdrawn is asked about twice", async () => {
  tellPeople(person(1, "teacher", {role: "operate"}));
  await openClass({refusal: "'teacher' is the last person with the role"});
  await press("Withdraw");
  expect(gateway.published).toEqual([]);
  await press("Really withdraw?");
  await reads("#class-dialog .word", "'teacher' is the last person with the role");
  expect(gateway.published).toEqual([{tag: 1, op: "person_withdraw", person: 1}]);
});

test("the wall shows who presses too hard, and a teacher begins, speaks, mutes and watches", async () => {
  const tell = (station: string, phase: string): void =>
    gateway.retain("/palpate/session_state", sessionState(station, phase, kSeat.name, "ball"));
  tellPeople(person(1, "Anna", {seat: kSeat.name}), person(2, "Ben"), person(3, "Cleo", {here: 0}));
  gateway.retain("/palpate/goal", {scene: kSeat.name, text: "Gently", limit_N: 0.25});
  tell("Anna", "active");
  tell("Ben", "held");
  move((sequence) =>
    gateway.send("/palpate/tool_state", {...pressed("Anna", sequence, 2), scene: kSeat.name}),
  );
  await openClass({});
  await eventually("too much", async () =>
    /2\.00 of 0\.25 N: too much/.test(await card("Anna").innerText()),
  );
  // Those who wait come first, those who are away last.
  expect(await page.locator(".wall b").allInnerTexts()).toEqual(["Ben", "Anna", "Cleo"]);
  expect(await card("Cleo").innerText()).toMatch(/not here/);
  expect(await text("#class-dialog .count")).toBe("2 of 3 are here");
  await page.fill("#class-goal", "Six sites");
  await page.fill("#class-limit", "0.25");
  await press("Begin for all");
  await eventually("three wishes", () => gateway.published.length === 3);
  await card("Anna").getByRole("button", {name: "Mute"}).click();
  await card("Anna").getByRole("button", {name: "Say…"}).click();
  await page.keyboard.type("Lighter");
  await page.keyboard.press("Enter");
  await eventually("five wishes", () => gateway.published.length === 5);
  expect(gateway.published).toEqual([
    {op: "goal", scene: kTestScene.name, text: "Six sites", limit_N: 0.25},
    {tag: 1, op: "begin", scene: kTestScene.name},
    {op: "admit", station: "Ben"},
    {op: "mute", station: "Anna"},
    {tag: 2, op: "say", person: 1, text: "Lighter"},
  ]);
  await card("Anna").getByRole("button", {name: "Watch"}).click();
  await eventually("her seat", async () => (await probe(page)).scene === kSeat.name);
  expect(new URL(page.url()).searchParams.get("station")).toBe("Anna");
});

test("a student goes to the own seat in the own view, reads the teacher's line, and has no class", async () => {
  gateway.role = "drive";
  gateway.hasCourse = true;
  const me = {person: 2, name: "Anna", role: "drive", seat: "", line: "", lines: 0};
  gateway.retain("/palpate/me", me);
  await open();
  gateway.send("/palpate/me", {...me, seat: kSeat.name, line: "Gently", lines: 1});
  await appears(".said");
  expect(await text(".said span")).toBe("Gently");
  await eventually("the seat", async () => (await probe(page)).scene === kSeat.name);
  await page.locator("body.student").waitFor();
  await press("Hide");
  gateway.send("/palpate/me", {...me, seat: kSeat.name, line: "Gently", lines: 1});
  gateway.send("/palpate/me", {...me, seat: kSeat.name, line: "Well done", lines: 2});
  await reads(".said span", "Well done");
});

test.each([
  ["a phone", {width: 390, height: 844}],
  ["a small window", {width: 800, height: 500}],
])(
  "on %s the teacher's line, a complaint and the trial cover nothing of each other",
  async (_, viewport) => {
    gateway.role = "drive";
    gateway.hasCourse = true;
    gateway.retain("/palpate/exercises", {exercises: [{...kExercise, guide: []}]});
    const me = {person: 2, name: "Anna", role: "drive", seat: "", line: "Gently, please", lines: 1};
    gateway.retain("/palpate/me", me);
    await open({viewport});
    await appears(".said");
    const isApart = async (...ids: string[]): Promise<void> => {
      const boxes = await Promise.all(ids.map((id) => page.locator(id).boundingBox()));
      boxes.sort((a, b) => a!.y - b!.y);
      boxes
        .slice(1)
        .forEach((box, i) => expect(box!.y).toBeGreaterThan(boxes[i]!.y + boxes[i]!.height));
    };
    gateway.send("/palpate/trial_state", trialState("scored", {points: 81}));
    await appears("#trial-bar");
    await appears("#banner"); // nobody moves a tool
    await isApart("#banner", ".said", "#trial-bar");
    gateway.send("/palpate/exam_state", ownExam());
    await appears("#exam-bar");
    await isApart("#banner", ".said", "#exam-bar");
  },
);

test.each([
  ["a projector", {width: 1280, height: 720}, "en"],
  ["a projector, in German", {width: 1280, height: 720}, "de"],
  ["a phone, in German", {width: 390, height: 844}, "de"],
])(
  "on %s a teacher's bar has room for all, and for the scene's name",
  async (_, viewport, language) => {
    gateway.role = "operate";
    gateway.hasCourse = true;
    gateway.retain("/palpate/exercises", {exercises: []});
    tellPeople(person(1, "teacher", {role: "operate"}));
    await open({viewport});
    await chooseLanguage(language);
    await page.locator("#settings").click();
    await page.locator("#projector").check();
    await page.keyboard.press("Escape");
    const widths = await page
      .locator(".bar select")
      .evaluateAll((all) => all.map((one) => one.clientWidth));
    for (const width of widths) expect(width).toBeGreaterThan(100);
    const beyond = await page
      .locator(".bar > *")
      .evaluateAll(
        (all) => all.filter((one) => one.getBoundingClientRect().right > innerWidth).length,
      );
    expect(beyond).toBe(0);
    if (viewport.width < viewport.height) return;
    // A room reads the figures: what is above them takes one row.
    const high = async (of: string): Promise<number> =>
      (await page.locator(of).boundingBox())!.height;
    expect(await high(".bar")).toBeLessThan(2 * (await high("#audience")));
    expect(await high("#force")).toBeGreaterThan(1.5 * (await high("#audience")));
  },
);

test("the list of exercises says where and with what each is done, and a teacher what serves them", async () => {
  gateway.role = "operate";
  gateway.hasCourse = true;
  const graded = [{name: {en: "Nerve untouched"}, points: 25, gates: false, harms: true}];
  const named = (name: string, scene: string): object => ({
    ...{...kExercise, name, scene, graded},
    tools: [kExercise.tool, "pear-010"],
    serve: `${scene}.json`,
  });
  const exercises = [named("one", kTestScene.name), named("two", "elsewhere")];
  gateway.retain("/palpate/exercises", {exercises});
  const me = {person: 2, name: "Anna", role: "drive", seat: "", line: "", lines: 0};
  gateway.retain("/palpate/me", me);
  await open();
  await page.locator("#exercises-open").click();
  await reads("#exercises-dialog .list li:nth-child(1)", /In test-box, with the ball$/);
  await reads("#exercises-dialog .list li:nth-child(2)", /Not served now: scene elsewhere, tool/);
  await reads("#exercises-dialog .server p.quiet", "1 of 2 exercises are served now.");
  await reads("#exercises-dialog pre", /palpate-server test-box.json elsewhere.json --seats \d+/);
  await reads("#exercises-dialog .graded", /^Nerve untouched: 25\. Harm:/);
  await page.locator("#exercises-dialog .about select").selectOption("pear-010");
  await press("Begin");
  await eventually("a trial with that bur", () => gateway.published.length > 0);
  expect(gateway.published).toEqual([{op: "begin", exercise: "one", tool: "pear-010"}]);
  await page.locator("#exercises-open").click();
  gateway.send("/palpate/me", {...me, seat: "another-1"});
  gateway.send("/palpate/exercises", {exercises});
  await reads("#exercises-dialog .list li:nth-child(1)", /another-1/);
  expect(await page.locator("#exercises-dialog .begin").isDisabled()).toBe(true);
});

test("student and teacher are told who waits for a score, and what could not be scored or entered", async () => {
  gateway.role = "operate";
  gateway.hasCourse = true;
  const failed = {n: 1, points: null, passed: false, whole: true, submitted: true, page: ""};
  const done = [{...failed, reason: "stopped; no score: its scoring hung"}];
  gateway.retain("/palpate/exercises", {exercises: [{...kExercise, done, guide: []}]});
  const trial = {
    exercise: "light-force",
    n: 2,
    phase: "waiting",
    ahead: 3,
    reason: "",
    points: null,
  };
  const hung = "no score: its scoring hung and was ended after 390 s";
  tellPeople(
    person(1, "Anna", {trial}),
    person(2, "Ben", {trial: {...trial, phase: "scored", points: 81.4}}),
    person(3, "Cleo", {trial: {...trial, phase: "unscored", reason: hung}}),
    person(4, "Dora", {trial: null}),
  );
  await open();
  gateway.send("/palpate/trial_state", trialState("waiting", {ahead: 1}));
  await reads("#trial-bar [role=status]", "Recorded. It waits to be scored: 1 trial before it.");
  await page
    .locator("#trial-bar")
    .getByRole("button", {name: "Once more"})
    .waitFor({state: "hidden"});
  const full = "the disk is full: free some space, and do it again";
  gateway.send("/palpate/trial_state", trialState("unentered", {reason: full}));
  await reads(
    "#trial-bar [role=status]",
    /^Recorded and kept, but not entered yet: the disk is full/,
  );
  await press("Exercises");
  await reads("#exercises-dialog .done li", /no points.*its scoring hung/);
  await page.keyboard.press("Escape");
  await press("Class");
  await eventually("the queue", async () =>
    /trial 2: Recorded\. It waits to be scored: 3 trials before it/.test(
      await card("Anna").innerText(),
    ),
  );
  expect(await card("Ben").innerText()).toMatch(/light-force, trial 2: 81 of 100/);
  expect(await card("Cleo").locator(".trial.alarm").innerText()).toContain(hung);
  expect(await card("Dora").locator(".trial").isVisible()).toBe(false);
});

test("an examiner opens an exam, gives time and another trial, and closes it", async () => {
  gateway.retain("/palpate/exam_state", {...heldExam(), open: null});
  gateway.role = "operate";
  gateway.hasCourse = true;
  await open();
  await press("Exam");
  await press("Open the exam");
  await press("Really: Open the exam?");
  gateway.send("/palpate/exam_answer", {
    tag: 2,
    refusal: "the course has no person with the role 'drive'",
  });
  await reads("#exam-dialog .word", "the course has no person with the role 'drive'");
  gateway.send("/palpate/exam_state", heldExam());
  await reads("#exam-dialog section p:first-of-type", /clock was set by -3,?600 s/);
  await press("Give the 41 s back");
  await press("5 min more for all");
  await press("Once more");
  await press("Really: Once more?");
  expect(await text("#exam-dialog tbody li:last-child")).toMatch(/cut short: the gateway was/);
  const ben = page.locator("#exam-dialog tbody tr").nth(1);
  expect(await ben.innerText()).toMatch(/task 2: Caries\s+waits for a seat in .*, 2 before/);
  await eventually("the time of waiting goes on", async () =>
    /waited (?!1:30)\d+:\d\d in all/.test(await ben.innerText()),
  );
  await press("Close the exam");
  await press("Really: Close the exam?");
  await eventually("six wishes", () => gateway.published.length === 6);
  expect(gateway.published).toEqual([
    {tag: 1, op: "look"},
    {tag: 2, op: "open", exam: "midterm"},
    {tag: 3, op: "give_back"},
    {tag: 4, op: "more", s: 300},
    {tag: 5, op: "again", person: 2},
    {tag: 6, op: "close"},
  ]);
});

test("after a kill of the gateway a candidate is at a task that is to begin, and in no trial", async () => {
  const stand = (...states: [string, object][]): void => {
    gateway.role = "drive";
    gateway.hasCourse = true;
    for (const [topic, state] of states) gateway.retain(topic, state);
  };
  stand(["/palpate/exam_state", ownExam()]);
  await open();
  gateway.send("/palpate/trial_state", trialState("running"));
  await reads("#exam-bar .times .clock:last-child", /^This task: \d:/);
  await gateway.stop();
  await startGateway();
  stand(["/palpate/exam_state", ownExam({trial: 2, cut: "the gateway was killed"})]);
  await reads("#exam-bar .word", /^cut short: the gateway was killed/i);
  await page.getByRole("button", {name: "Begin this task"}).waitFor();
  expect(await text("#exam-bar .times .clock:last-child")).toBe("");
  expect(await page.getByRole("button", {name: "Hand in"}).isVisible()).toBe(false);
  await press("Begin this task");
  await eventually("a wish", () => gateway.published.length === 1);
});

test("who sits an exam sees its next task and the time, no exercises, and hands in", async () => {
  gateway.role = "drive";
  gateway.hasCourse = true;
  gateway.retain("/palpate/exercises", {exercises: []});
  await open();
  await page.getByRole("button", {name: "Exercises"}).waitFor();
  gateway.send("/palpate/exam_state", ownExam());
  await reads("#exam-bar .times span:first-child", "Task 1 of 3, trial 1 of 2");
  expect(await page.getByRole("button", {name: "Exercises"}).isVisible()).toBe(false);
  expect(await page.locator("#scene").isVisible()).toBe(false);
  const begin = page.getByRole("button", {name: "Begin this task"});
  await press("Begin this task");
  await eventually("a wish", () => gateway.published.length === 1);
  gateway.send("/palpate/exam_state", ownExam(ownTurn("waits", {ahead: 1})));
  await reads(
    "#exam-bar .word",
    /with 1 other before you. There work: Ben, Cleo. Your time stands/,
  );
  expect(await begin.isVisible()).toBe(false);
  expect(await text("#exam-bar .times .clock:nth-child(2)")).toBe("Exam: 10:00 left");
  const {name: scene} = kTestScene;
  gateway.send("/palpate/exam_state", ownExam(ownTurn("called", {seat: scene, left_s: 60})));
  await reads("#exam-bar .word", /is free. Begin within 0:\d\d/);
  await press("Begin this task");
  await eventually("another", () => gateway.published.length === 2);
  gateway.published.shift();
  const told = {station: "anna", scene, tool: "ball", reason: ""};
  gateway.send("/palpate/mouse_state", {...told, phase: ""});
  await until(page, "the tool to come", ({hold}) => hold === "asking");
  gateway.send("/palpate/trial_state", trialState("running"));
  await reads("#force-bar-mass", "25 g"); // the task's limit
  gateway.send("/palpate/mouse_state", {...told, phase: "active"});
  await until(page, "the tool", ({hold}) => hold === "holding");
  for (const reflex of ["Escape", "m"]) await page.keyboard.press(reflex);
  await reads("#hint-action", "Really: Hand in?");
  await press("Hand in");
  await eventually("another", () => gateway.published.length === 2);
  await page.locator("#hint-action").click();
  await eventually("the same", () => gateway.published.length === 3);
  const stop = {op: "stop"};
  expect(gateway.published).toEqual([{op: "begin", exercise: "light-force"}, stop, stop]);
  gateway.send("/palpate/trial_state", trialState("kept"));
  gateway.send("/palpate/exam_state", ownExam({task: 3, exercise: undefined}));
  await reads(
    "#exam-bar .word",
    "You have done all tasks. The points come when the exam is closed.",
  );
});

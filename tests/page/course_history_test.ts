// What was done so far, in a real browser at a gateway that does what a test says.
import {readFileSync} from "node:fs";

import {expect} from "vitest";

import {
  appears,
  atGatewayUnseen,
  chooseLanguage,
  gateway,
  open,
  page,
  reads,
  vanishes,
} from "./support/at_gateway";
import {kClassHistory, kPersonHistory} from "./support/made_up_history";
import {kTestScene} from "./support/scene_bytes";
import {browserTest as test} from "./support/skip";

atGatewayUnseen(kTestScene);

const press = (name: string): Promise<void> =>
  page.locator("#history-dialog").getByRole("button", {name, exact: true}).click();
const names = (): Promise<string[]> => page.locator("#history-dialog tbody .name").allInnerTexts();

async function openHistory(role: string): Promise<void> {
  gateway.role = role;
  gateway.hasCourse = true;
  gateway.files.set("/history/class.json", JSON.stringify(kClassHistory));
  gateway.files.set("/history/2.json", JSON.stringify(kPersonHistory));
  gateway.files.set("/history/class.csv", "person\r\n");
  const person = role === "operate" ? 1 : 2;
  gateway.retain("/palpate/me", {person, name: "", role, seat: "", line: "", lines: 0});
  await open();
  await page.locator("#history-open").click();
}

test("a teacher sees everybody, who needs help first, and opens a person's trials", async () => {
  await openHistory("operate");
  await appears("#history-dialog tbody tr:first-child");
  expect(await names()).toEqual(["Ben", "Zoe", "Cleo"]);
  await page.locator("#history-dialog thead").getByRole("button", {name: "Grade"}).click();
  await reads("#history-dialog [aria-sort=ascending]", /Grade/);
  expect(await names()).toEqual(["Zoe", "Ben", "Cleo"]);
  expect(await page.locator("#history-exercise option").allInnerTexts()).toEqual([
    "Walking along the margin (margin-walking)",
    "Walking along the margin (two)", // told apart by their names
    "old-one",
  ]);
  await reads("#history-dialog tbody tr:nth-child(2) .grade", "75 ± 39");
  await reads("#history-dialog tbody tr:nth-child(1) .grade", /^40 below/);
  await reads("#history-dialog .losses li:first-child", /Floor felt all along\s+−12/);
  const csv = page.waitForEvent("download");
  await press("As a table (CSV)");
  expect((await csv).suggestedFilename()).toBe("palpate-class.csv");
  await press("Ben");
  await reads("#history-title", "Ben");
  await reads("#history-dialog .next li:first-child", /−12\s+Floor felt all along\s+Walking along/);
  await reads("#history-dialog article:first-of-type .figure b", "75 ± 39");
  await page.locator("#history-dialog summary").first().click();
  const rows = page.locator("#history-dialog article:first-of-type tbody tr");
  expect(await rows.count()).toBe(4);
  expect(await rows.locator("a").first().getAttribute("href")).toBe("score/key3#en");
  expect(await rows.first().innerText()).toMatch(/not whole, its scoring hung/);
  await reads("#history-dialog article:last-of-type h3", "old-one"); // it is gone: its name is left
  await press("← The class");
  await appears("#history-exercise");
});

test("a table is written as its reader chooses, and as the language is used to until then", async () => {
  await openHistory("operate");
  for (const as of ["comma", "semicolon"])
    gateway.files.set(`/history/class.${as}.csv`, `person;${as}\r\n`);
  const as = page.locator("#history-dialog .csv-as");
  expect(await as.locator("option").allInnerTexts()).toEqual([
    ", and 0.5",
    "; and 0.5",
    "; and 0,5",
  ]);
  expect(await as.inputValue()).toBe(".csv");
  const read = async (button: string): Promise<string> => {
    const csv = page.waitForEvent("download");
    await press(button);
    return readFileSync((await (await csv).path())!, "utf8");
  };
  expect(await read("As a table (CSV)")).toBe("person\r\n");
  await page.locator("#history-dialog").getByRole("button", {name: "Close"}).click();
  await chooseLanguage("de");
  await page.locator("#history-open").click();
  expect(await as.inputValue()).toBe(".comma.csv");
  expect(await read("Als Tabelle (CSV)")).toBe("person;comma\r\n");
  await as.selectOption(".semicolon.csv");
  expect(await read("Als Tabelle (CSV)")).toBe("person;semicolon\r\n");
  await page.reload();
  await page.locator("#history-open").click();
  expect(await as.inputValue()).toBe(".semicolon.csv");
});

test("who is deleted is asked about twice, and a refusal is told", async () => {
  await openHistory("operate");
  await press("Ben");
  await press("Delete…");
  await press("Keep");
  await vanishes("#history-dialog .question");
  gateway.onPublish = ({tag}) =>
    gateway.send("/palpate/class_answer", {
      tag,
      refusal: "a trial is running",
      note: "",
      people: [],
    });
  const remove = async (): Promise<void> => {
    await press("Delete…");
    await press("Delete all of it");
    await reads("#history-dialog .question", /Really delete all that there is of Ben/);
    await press("Yes, for good");
  };
  expect(gateway.published).toEqual([]);
  await remove();
  await reads("#history-dialog .word", "a trial is running");
  expect(gateway.published).toEqual([{tag: 1, op: "person_delete", person: 2}]);
  gateway.onPublish = ({tag}) =>
    gateway.send("/palpate/class_answer", {tag, refusal: "", note: "", people: []});
  await remove();
  await reads("#history-dialog .word", "Ben is deleted.");
  await appears("#history-exercise");
});

test("a student sees the own trials, and nobody else's", async () => {
  await openHistory("drive");
  await reads("#history-title", "How it went so far");
  await appears("#history-dialog .next li:first-child");
  await appears("#history-dialog article:first-of-type .curve canvas");
  for (const name of ["← The class", "Delete…"])
    expect(await page.getByRole("button", {name, exact: true}).isVisible(), name).toBe(false);
  await page.getByRole("button", {name: "All data (ZIP)"}).waitFor();
});

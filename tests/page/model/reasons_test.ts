import {readFileSync} from "node:fs";
import {dirname, join} from "node:path";
import {fileURLToPath} from "node:url";

import {afterEach, describe, expect, test} from "vitest";

import {speak} from "@page/messages/say";
import {tellNames} from "@page/model/names";
import {sayReason} from "@page/model/reasons";

const read = (path: string): string =>
  readFileSync(fileURLToPath(new URL(`../../../${path}`, import.meta.url)), "utf8");
const english: Record<string, string> = JSON.parse(read("client/page/src/messages/en.json"));
const reasons = Object.entries(english)
  .filter(([key]) => key.startsWith("reason."))
  .map(([, text]) => text);

/// The sources whose texts reach a page, each with how those begin that do not: they are for a
/// terminal, or for another program.
const kSources: Readonly<Record<string, readonly string[]>> = {
  "client/course/course_file.cpp": ["--course", "{}: was written by a newer Palpate"],
  "client/course/exam_room.cpp": ["; no score: "],
  "client/course/exam_seals.cpp": [],
  "client/course/exam_seals.h": [],
  "client/course/person_name.cpp": ["ICU", "Any-Latin"],
  "client/course/roster.cpp": [],
  "client/course/running_trials.cpp": [],
  "client/course/seal.cpp": [
    ...["palpate {}", "OpenSSL", "{}: cannot create the key", "the exams' key"],
    ...["public key", ": is not an Ed25519 key", ": is not the public key"],
  ],
  "client/course/trial.cpp": ["recording to "],
  "client/replayer/play/bookmarks.cpp": ["holds more than ", "; drop some"],
  "client/replayer/play/steering.cpp": [],
  "client/replayer/play/timeline.cpp": ["the recording's scene "],
  "client/replayer/score/trial_cut.cpp": [],
  "client/viewer/class_room.cpp": ["has more than {} bytes"],
  "client/viewer/course_desk.cpp": [],
  "client/viewer/hub.cpp": [],
  "client/viewer/mouse_room.cpp": [],
  "client/viewer/mouse_station.cpp": [],
  "client/viewer/rights.cpp": ["this connection ends"],
  "client/viewer/server_desk.cpp": [],
  "client/viewer/tool_desk.cpp": [],
  "client/viewer/topic_feed.cpp": [],
  "client/viewer/viewers.cpp": ["its place is"],
  "client/viewer/wish_limits.cpp": [],
  "common/program/child_program.cpp": [],
  "server/session/session.cpp": [],
  "server/session/session_table.cpp": [],
};
/// Of these, what they throw.
const kThrow: typeof kSources = {
  "client/course/exam_table.cpp": [],
  "client/course/person_data.cpp": [
    "cannot write the ZIP",
    ": cannot be read",
    "the course's disk",
    "; the folder",
  ],
  "client/replayer/hand_path.cpp": ["no session of station", "{} sessions; choose one"],
  "client/replayer/score/score_report.cpp": [
    "; give another",
    ": exists already",
    ": has no criteria",
    "; omit it",
  ],
  "client/station/session_link.cpp": [],
  "common/mcap/mcap_writer.cpp": [": has all the "],
};
/// And these have a few such texts among others.
const kFew = [
  "client/replayer/score/words/en.json",
  "client/replayer/play/player.cpp",
  "client/station/served_tools.cpp",
  "client/viewer/viewer_session.cpp",
  "common/files/whole_file.cpp",
  "common/mcap/mcap_reader.cpp",
  "scenes/catalogue.cpp",
  "scenes/tree/sphere_tree_builder.cpp",
  "server/transport/server.cpp",
];

const codeOf = (path: string): string =>
  read(path)
    .replace(/\/\/.*|#include.*/g, "")
    .replace(/R"\(.*?\)"/gs, "")
    .replace(/"\s*\n\s*"/g, "");
const kArguments = String.raw`\((?:[^;"]|"(?:[^"\\\n]|\\.)*")*\);`;
const textsIn = (code: string): string[] =>
  [...code.matchAll(/"((?:[^"\\\n]|\\.)*)"/g)].map(([, text]) => text!);
const withoutLogs = (code: string): string =>
  code.replace(new RegExp(String.raw`spdlog::\w+${kArguments}`, "g"), "");
const whatIsThrown = (code: string): string =>
  (code.match(new RegExp(String.raw`throw Error${kArguments}`, "g")) ?? []).join("");
const piecesOf = (text: string): string[] => text.split(/\{[^}]*\}/);
const isSql = (text: string): boolean =>
  /\b(SELECT|INSERT|UPDATE|DELETE|CREATE|PRAGMA)\b/.test(text);

test("every reason that reaches a page is known to it", () => {
  const known = reasons.flatMap(piecesOf);
  const unknownOf = (code: string, others: readonly string[]): string[] =>
    textsIn(code)
      .filter((text) => !isSql(text) && !others.some((other) => text.startsWith(other)))
      .flatMap(piecesOf)
      .filter((piece) => /[a-z]{2}.* .*[a-z]/.test(piece))
      .filter((piece) => !known.some((reason) => reason.includes(piece)));
  for (const [path, others] of Object.entries(kSources))
    expect(unknownOf(withoutLogs(codeOf(path)), others), path).toEqual([]);
  for (const [path, others] of Object.entries(kThrow))
    expect(unknownOf(whatIsThrown(codeOf(path)), others), path).toEqual([]);
});

/// What the system says: the libraries that say it, this process's C library and SQLite beside it.
const libC = (process.report.getReport() as {sharedObjects: string[]}).sharedObjects.find((path) =>
  path.includes("/libc.so"),
)!;
const systems = [libC, join(dirname(libC), "libsqlite3.so.0")].map((path) => readFileSync(path));
const isSystems = (reason: string): boolean =>
  systems.some((library) => library.includes(`\0${reason}\0`));

test("the page knows no reason that nobody gives", () => {
  const given = [...Object.keys({...kSources, ...kThrow}), ...kFew]
    .flatMap((path) => textsIn(codeOf(path)))
    .flatMap(piecesOf)
    .filter((piece) => piece.trim().length > 3)
    .sort((a, b) => b.length - a.length);
  const restOf = (reason: string): string => {
    let rest = piecesOf(reason).join("|");
    for (const piece of given) rest = rest.replaceAll(piece, "|");
    return rest;
  };
  const left = reasons.filter((reason) => /[a-z]{3}/.test(restOf(reason)) && !isSystems(reason));
  expect(left).toEqual([]);
});

describe("a reason", () => {
  afterEach(() => speak("en"));

  test("is said in the page's language, with what it holds", async () => {
    const seat = "'caries-2' is the seat of another person, and you have none; ask your teacher";
    expect(sayReason(seat)).toBe(seat);
    await speak("de");
    expect(sayReason(seat)).toBe(
      "„caries-2“ ist der Platz einer anderen Person, und Sie haben keinen; fragen Sie Ihre Lehrperson",
    );
    expect(sayReason("cut short: its page did not come back within 30 s")).toBe(
      "abgebrochen: die Seite kam nicht innerhalb von 30 s zurück",
    );
    await speak("zh");
    expect(sayReason("stopped; no score: its recorder ended")).toBe(
      "已停止；没有评分：记录程序已结束",
    );
  });

  test("holds what the system says, in the page's language", async () => {
    await speak("de");
    expect(sayReason("stopped; a/1.mcap: No space left on device; record to another place")).toBe(
      "angehalten; a/1.mcap: auf dem Datenträger ist kein Platz mehr; zeichnen Sie anderswo auf",
    );
    await speak("zh");
    expect(
      sayReason("course.sqlite: database or disk is full; look whether its disk is full or fails"),
    ).toBe("course.sqlite：数据库或磁盘已满；请检查磁盘是否已满或出现故障");
  });

  test("names people, not their stations", async () => {
    tellNames([["x738bx4f1f", "Александр"]]);
    await speak("de");
    expect(
      sayReason(
        "tool 'bur' of scene 'caries' is driven by station 'x738bx4f1f'; end that station, or drive another tool",
      ),
    ).toBe(
      "das Instrument „bur“ der Szene „caries“ führt Александр; warten Sie, bis es frei ist, oder nehmen Sie ein anderes",
    );
  });

  test("that is not known stays as it is, also after one that is", async () => {
    await speak("de");
    expect(sayReason("")).toBe("");
    expect(sayReason("the moon is full; sleep")).toBe("the moon is full; sleep");
    expect(sayReason("stopped; the moon is full")).toBe("angehalten; the moon is full");
  });
});

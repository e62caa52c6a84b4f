import {readdirSync, readFileSync} from "node:fs";
import {fileURLToPath} from "node:url";

import {afterEach, describe, expect, test} from "vitest";

import {chooseLanguage, kLanguages, say, sayList, sayNumber, speak} from "@page/messages/say";
import {figure, recordedWhen, spokenTime} from "@page/model/words";

type Catalogue = Record<string, string>;

const page = (path: string): string =>
  fileURLToPath(new URL(`../../../client/page/${path}`, import.meta.url));
const catalogue = (language: string): Catalogue =>
  JSON.parse(readFileSync(page(`src/messages/${language}.json`), "utf8"));
const english = catalogue("en");

/// {name} and {count, plural, …}: of the latter, its forms apart.
const placeholders = (text: string): string[] =>
  [...text.matchAll(/\{(\w+)(, plural,)?/g)]
    .filter(([whole, , isPlural]) => isPlural || text.includes(`${whole}}`))
    .map(([, name, isPlural]) => name! + (isPlural ?? ""))
    .sort();

const sources = (): string =>
  readdirSync(page("src"), {recursive: true, encoding: "utf8"})
    .filter((file) => file.endsWith(".ts"))
    .map((file) => readFileSync(page(`src/${file}`), "utf8"))
    .join("\n");

afterEach(() => speak("en"));

describe.each(kLanguages)("the catalogue %s", (language) => {
  const own = catalogue(language);

  test("has every message, with every value that it stands for, and no other", () => {
    expect(Object.keys(own).sort()).toEqual(Object.keys(english).sort());
    for (const [key, text] of Object.entries(english)) {
      expect(placeholders(own[key]!), key).toEqual(placeholders(text));
      expect(own[key]!.trim(), key).not.toBe("");
    }
  });

  test("has each plural's forms, as its language counts", () => {
    const {pluralCategories} = new Intl.PluralRules(own.locale).resolvedOptions();
    for (const [key, text] of Object.entries(own)) {
      const forms = /\{\w+, plural, (.*)\}$/s.exec(text)?.[1];
      if (forms === undefined) continue;
      const named = [...forms.matchAll(/(\w+) \{/g)].map(([, form]) => form!);
      expect(named.sort(), key).toEqual([...pluralCategories].sort());
    }
  });
});

test("every message is said somewhere, and index.html says none that there is not", () => {
  const html = readFileSync(page("index.html"), "utf8");
  const inHtml = [...html.matchAll(/data-say[\w-]*="([^"]*)"/g)].map(([, key]) => key!);
  for (const key of inHtml) expect(english).toHaveProperty([key]);
  const code = sources();
  const literal = new Set([...code.matchAll(/"(\w+(?:\.\w+)?)"/g)].map(([, text]) => text!));
  const begun = [...code.matchAll(/`(\w+\.\w*)\$\{/g)].map(([, text]) => text!);
  const unused = Object.keys(english).filter(
    (key) =>
      key !== "locale" &&
      !key.startsWith("reason.") && // see model/reasons_test.ts
      !inHtml.includes(key) &&
      !literal.has(key) &&
      !begun.some((beginning) => key.startsWith(beginning)),
  );
  expect(unused).toEqual([]);
});

test("no words stand in index.html itself, where nobody could translate them", () => {
  const [, body] = readFileSync(page("index.html"), "utf8").split("<body>");
  const words = body!
    .replace(/<noscript>.*<\/noscript>|<kbd>[^<]*<\/kbd>/g, "")
    .replace(/<[^>]*>/g, " ")
    .match(/\w{2,}/g);
  expect(new Set(words)).toEqual(new Set(["Palpate", "mN", "mm"]));
  expect(body).not.toMatch(/[ \n](title|aria-label|placeholder)="\w/);
});

test("the reader's first language that there is, is the page's", () => {
  const files = readdirSync(page("src/messages")).filter((file) => file.endsWith(".json"));
  expect(kLanguages.map((language) => `${language}.json`)).toEqual(files.sort());
  expect(chooseLanguage(["de-AT", "en"])).toBe("de");
  expect(chooseLanguage(["fr-FR", "zh-Hant-TW", "de"])).toBe("zh");
  expect(chooseLanguage(["fr"])).toBe("en");
  expect(chooseLanguage([])).toBe("en");
});

test("numbers, counts and times are written as the language writes them", async () => {
  expect(figure(0.245, 3)).toBe("0.245");
  expect(say("loop.poses", {count: 1})).toBe("1 pose");
  expect(say("loop.poses", {count: 1200})).toBe("1,200 poses");
  await speak("de");
  expect(figure(0.245, 3)).toBe("0,245");
  expect(say("goal.at_most", {limit: 0.245})).toBe("höchstens 0,245 N");
  expect(say("loop.poses", {count: 1200})).toBe("1.200 Lagen");
  expect(spokenTime(61)).toBe("1 Minute 1 Sekunde");
  expect(recordedWhen(Date.UTC(2026, 2, 12, 13, 3) / 1000)).toMatch(
    /^aufgezeichnet 1[23]\.03\.2026/,
  );
  await speak("zh");
  expect(say("loop.poses", {count: 1})).toBe("1 个位姿");
  expect(sayList("list.separator", ["a", "", "b"])).toBe("a，b");
  expect(sayNumber(1234.5, 1)).toBe("1234.5");
});

test("score pages name tissues as this page does", () => {
  for (const language of kLanguages) {
    const score: Catalogue = JSON.parse(
      readFileSync(page(`../replayer/score/words/${language}.json`), "utf8"),
    );
    const tissues = Object.entries(score).filter(([key]) => key.startsWith("tissue."));
    expect(tissues.length).toBeGreaterThan(0);
    expect(catalogue(language)).toMatchObject(Object.fromEntries(tissues));
  }
});

test("who asks for a language that there is not hears English", async () => {
  await speak("de");
  await speak("xx");
  expect(say("tool.take")).toBe("Take the tool");
});

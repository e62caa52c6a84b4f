import {nameOf} from "./names";
import en from "../messages/en.json";
import {type Key, say, sayList, type Words} from "../messages/say";

/// Gateway, server, station and replayer give their reasons in English.  As such they are logged,
/// recorded, stored and sealed, so no code beside them could reach the page from everywhere.  The
/// page knows a reason by its English text: `reason.CODE` in messages/en.json has it word for word,
/// as tests/page/messages/reasons_test.ts holds.

interface Reason {
  readonly key: Key;
  readonly fields: readonly string[];
  readonly pattern: RegExp;
  readonly letters: number; // beside the fields
}

const kField = /\{(\w+)\}/g;
/// These hold a reason themselves: another program's, or the system's.
const kNested: readonly string[] = ["reason", "error"];

const reasonOf = (key: Key): Reason => {
  const parts = en[key].split(kField); // text, field, text, field, ..., text
  const texts = parts.filter((_, at) => at % 2 === 0);
  const escaped = texts.map((text) => text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
  // One that begins with a field, as a file's name, must not swallow the reason before it.
  const first = texts[0] === "" ? "((?:(?!; ).)+?)" : "";
  const rest = escaped.slice(first === "" ? 0 : 1);
  return {
    ...{key, fields: parts.filter((_, at) => at % 2 === 1)},
    pattern: new RegExp(`^${first}${rest.join("(.+?)")}$`, "s"),
    letters: texts.join("").length,
  };
};

/// The most exact first: several may fit.
const kReasons: readonly Reason[] = (Object.keys(en) as Key[])
  .filter((key) => key.startsWith("reason."))
  .map(reasonOf)
  .sort((a, b) => b.letters - a.letters);

function known(text: string): string | undefined {
  for (const {key, fields, pattern} of kReasons) {
    const found = pattern.exec(text);
    if (!found) continue;
    const value = (field: string, at: number): string => {
      const is = found[at + 1]!;
      return kNested.includes(field) ? sayReason(is) : field === "station" ? nameOf(is) : is;
    };
    return say(key, Object.fromEntries(fields.map((field, at) => [field, value(field, at)])));
  }
  // Several reasons, one after the other.
  for (let at = text.indexOf("; "); at >= 0; at = text.indexOf("; ", at + 1)) {
    const first = known(text.slice(0, at));
    if (first === undefined) continue;
    return sayList("list.clauses", [first, sayReason(text.slice(at + 2))]);
  }
  return undefined;
}

/// Says a program's reason in the page's language; one that is not known stays as it is.
export const sayReason = (text: string): string => known(text) ?? text;
/// The same for what follows the page's language.
export const reasonWords = (text: string): Words => (text === "" ? "" : () => sayReason(text));

import en from "./en.json";

/// The page's texts in the reader's language.  Each language has a catalogue, a map from flat key
/// to text, in a file beside this one that is named by its BCP 47 tag.  `{name}` is replaced by a
/// value, `{count, plural, one {# step} other {# steps}}` by a number with its noun, using the
/// plural rules of the catalogue's locale.

export type Key = keyof typeof en;
export type Values = Readonly<Record<string, string | number>>;
type Catalogue = Readonly<Record<string, string>>;

/// A text, or how it is said: the latter follows the page's language.
export type Words = string | (() => string);
export const textOf = (words: Words): string => (typeof words === "string" ? words : words());

/// The build finds every catalogue: a new language needs only a new file.
const kOthers = import.meta.glob<Catalogue>(["./*.json", "!./en.json"], {import: "default"});
const fileOf = (tag: string): string => `./${tag}.json`;

export const kLanguages: readonly string[] = [
  "en",
  ...Object.keys(kOthers).map((file) => file.slice(2, -".json".length)),
].sort();

let catalogue: Catalogue = en;
let plurals = new Intl.PluralRules(en.locale);
let formats = new Map<number, Intl.NumberFormat>(); // by number of digits

/// Returns the first of the reader's languages that has a catalogue; zh-Hant-TW falls back to zh.
export function chooseLanguage(wanted: readonly string[]): string {
  for (const tag of wanted) {
    const parts = tag.split("-");
    for (let count = parts.length; count > 0; count--) {
      const nearer = parts.slice(0, count).join("-").toLowerCase();
      const found = kLanguages.find((language) => language.toLowerCase() === nearer);
      if (found !== undefined) return found;
    }
  }
  return "en";
}

/// Loads a language for all later texts; `sayAgain` (ui/spoken.ts) changes those already shown.
/// @param isWanted  whether it still is, once it has been fetched
export async function speak(language: string, isWanted = (): boolean => true): Promise<void> {
  const fetched = (await kOthers[fileOf(language)]?.()) ?? en;
  if (!isWanted()) return;
  catalogue = fetched;
  plurals = new Intl.PluralRules(locale());
  formats = new Map();
}

/// The locale in which numbers and times are written.
export const locale = (): string => catalogue.locale ?? en.locale;

const kPlaceholder = /\{(\w+)(?:, plural, ((?:\w+ \{[^{}]*\}\s*)+))?\}/g;

/// Whether there is such a text, as for what a scene may name.
export const hasText = (key: string): key is Key => key in en;

export function say(key: Key, values: Values = {}): string {
  const text = catalogue[key] ?? en[key];
  return text.replace(kPlaceholder, (whole, name: string, forms: string | undefined) => {
    const value = values[name];
    if (value === undefined) return whole;
    const written = typeof value === "number" ? value.toLocaleString(locale()) : value;
    return forms === undefined ? written : formOf(forms, Number(value)).replaceAll("#", written);
  });
}

function formOf(forms: string, count: number): string {
  const known = new Map(
    [...forms.matchAll(/(\w+) \{([^{}]*)\}/g)].map(([, of, text]) => [of, text]),
  );
  return known.get(plurals.select(count)) ?? known.get("other") ?? "";
}

/// Returns a number with this many decimals and no thousands separators, for figures that change
/// while they are read.
export function sayNumber(value: number, digits: number): string {
  let format = formats.get(digits);
  if (!format) {
    const exactly = {minimumFractionDigits: digits, maximumFractionDigits: digits};
    format = new Intl.NumberFormat(locale(), {...exactly, useGrouping: false});
    formats.set(digits, format);
  }
  return format.format(value);
}

/// Joins the non-empty parts of a sentence.
export const sayList = (key: "list.separator" | "list.clauses", parts: readonly string[]): string =>
  parts.filter((part) => part !== "").join(say(key));

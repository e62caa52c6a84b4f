import en from "./en.json";

/// What the page says, in the reader's language: a catalogue for each, FLAT-KEY to text, in a file named by
/// its BCP 47 tag beside this one.  `{name}` stands for a value, `{count, plural, one {# step} other {#
/// steps}}` for a number with what it counts, by the plural rules of the catalogue's locale.

export type Key = keyof typeof en;
export type Values = Readonly<Record<string, string | number>>;
type Catalogue = Readonly<Record<string, string>>;

/// A language more is a file more: the build finds it.
const kOthers = import.meta.glob<Catalogue>(["./*.json", "!./en.json"], {import: "default"});
const fileOf = (tag: string): string => `./${tag}.json`;

export const kLanguages: readonly string[] = [
  "en",
  ...Object.keys(kOthers).map((file) => file.slice(2, -".json".length)),
].sort();

let catalogue: Catalogue = en;
let plurals = new Intl.PluralRules(en.locale);
let formats = new Map<number, Intl.NumberFormat>(); // by digits

/// The first of the reader's languages that there is: zh-Hant-TW finds zh where there is nothing nearer.
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

/// What the page says from now on; what it has said stays.
export async function speak(language: string): Promise<void> {
  catalogue = (await kOthers[fileOf(language)]?.()) ?? en;
  plurals = new Intl.PluralRules(locale());
  formats = new Map();
}

/// That numbers and times are written by.
export const locale = (): string => catalogue.locale ?? en.locale;

const kPlaceholder = /\{(\w+)(?:, plural, ((?:\w+ \{[^{}]*\}\s*)+))?\}/g;

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

/// With so many digits after the point, and no thousands apart: a figure that is read while it moves.
export function sayNumber(value: number, digits: number): string {
  let format = formats.get(digits);
  if (!format) {
    const exactly = {minimumFractionDigits: digits, maximumFractionDigits: digits};
    format = new Intl.NumberFormat(locale(), {...exactly, useGrouping: false});
    formats.set(digits, format);
  }
  return format.format(value);
}

/// Parts of a sentence, those that say nothing left out.
export const sayList = (key: "list.separator" | "list.clauses", parts: readonly string[]): string =>
  parts.filter((part) => part !== "").join(say(key));

/// In the reader's language, else in English, else in whatever there is.
export function localText(text: Readonly<Record<string, string>>, language: string): string {
  const [short = ""] = language.split("-");
  return text[language] ?? text[short] ?? text["en"] ?? Object.values(text)[0] ?? "";
}

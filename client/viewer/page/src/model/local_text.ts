/// Returns the text in the page's language, else in English, else in any language.
export function ownText(text: Readonly<Record<string, string>>): string {
  const language = document.documentElement.lang || "en";
  const [short = ""] = language.split("-");
  return text[language] ?? text[short] ?? text["en"] ?? Object.values(text)[0] ?? "";
}

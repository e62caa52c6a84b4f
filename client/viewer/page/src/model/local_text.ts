/// In the page's language, else in English, else in whatever there is.
export function ownText(text: Readonly<Record<string, string>>): string {
  const language = document.documentElement.lang || "en";
  const [short = ""] = language.split("-");
  return text[language] ?? text[short] ?? text["en"] ?? Object.values(text)[0] ?? "";
}

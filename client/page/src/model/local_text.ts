/// Returns the address of a score page, which reads its language from there.
export const scoreLink = (page: string): string =>
  `score/${page}#${document.documentElement.lang || "en"}`;

/// Returns the text in the page's language, else in English, else in any language.
export function ownText(text: Readonly<Record<string, string>>): string {
  const language = document.documentElement.lang || "en";
  const [short = ""] = language.split("-");
  return text[language] ?? text[short] ?? text["en"] ?? Object.values(text)[0] ?? "";
}

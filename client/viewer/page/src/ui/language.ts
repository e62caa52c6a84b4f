import {chooseLanguage, type Key, kLanguages, say, speak} from "../messages/say";
import {rememberInAddress} from "./address";
import {element} from "./elements";
import {keep, recall} from "./kept";

const kKey = "palpate-language";
const kInAddress = "lang";

/// The part of an element of index.html that a text fills, by the attribute with the message's key.
const kParts = {
  "data-say": "text",
  "data-say-title": "title",
  "data-say-label": "aria-label",
  "data-say-placeholder": "placeholder",
} as const;

/// Selects the page's language: the chosen one, the address's, or the browser's.
export async function speakToReader(): Promise<void> {
  const asked = new URLSearchParams(location.search).get(kInAddress);
  const chosen = recall("localStorage", kKey);
  const wanted = [chosen, asked, ...navigator.languages].filter((tag) => tag !== null);
  const language = chooseLanguage(wanted);
  await speak(language);
  document.documentElement.lang = language;
  for (const [attribute, part] of Object.entries(kParts)) {
    for (const found of document.querySelectorAll(`[${attribute}]`)) {
      const text = say(found.getAttribute(attribute) as Key);
      if (part === "text") found.textContent = text;
      else found.setAttribute(part, text);
    }
  }
  offerLanguages(language);
}

/// In their own names.  Choosing one reloads the page, since its texts are everywhere.
function offerLanguages(language: string): void {
  const select = element("language", HTMLSelectElement);
  for (const tag of kLanguages) {
    const name = new Intl.DisplayNames([tag], {type: "language"}).of(tag) ?? tag;
    const option = new Option(name, tag);
    option.lang = tag;
    select.add(option);
  }
  select.value = language;
  select.addEventListener("change", () => {
    keep("localStorage", kKey, select.value);
    // If the browser stores nothing, the address keeps the choice.
    const isKept = recall("localStorage", kKey) === select.value;
    rememberInAddress(kInAddress, isKept ? "" : select.value);
    location.reload();
  });
}

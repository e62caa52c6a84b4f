import {chooseLanguage, kLanguages, speak} from "../messages/say";
import {rememberInAddress} from "./address";
import {element} from "./elements";
import {keep, recall} from "../base/kept";
import {type Said, sayAgain, sayIn} from "./spoken";

const kKey = "palpate-language";
const kInAddress = "lang";

/// Selects the page's language: the chosen one, the address's, or the browser's.
export async function speakToReader(): Promise<void> {
  const asked = new URLSearchParams(location.search).get(kInAddress);
  const chosen = recall("localStorage", kKey);
  const wanted = [chosen, asked, ...navigator.languages].filter((tag) => tag !== null);
  const language = chooseLanguage(wanted);
  await speak(language);
  document.documentElement.lang = language;
  for (const found of document.querySelectorAll<HTMLElement>("body *"))
    sayIn(found, found.dataset as Said);
  offerLanguages(language);
}

/// In their own names.
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
    void change(select);
  });
}

async function change(select: HTMLSelectElement): Promise<void> {
  const {value} = select;
  await speak(value, () => select.value === value);
  if (select.value !== value) return; // another one was chosen while this one was fetched
  document.documentElement.lang = value;
  sayAgain();
}

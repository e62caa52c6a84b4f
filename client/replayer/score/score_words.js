// Says the page's texts in the reader's language: that of the address (#de), else the browser's.  The page
// defines `words` before this script.
const wanted = [location.hash.slice(1), ...navigator.languages].map((tag) => tag.split("-")[0].toLowerCase());
let language = wanted.find((tag) => tag in words) ?? "en";

const own = (text) =>
  typeof text === "string" ? text : (text[language] ?? text.en ?? Object.values(text)[0] ?? "");

function say(key, values = {}) {
  const text = words[language][key] ?? words.en[key] ?? key;
  return text.replace(/\{(\w+)\}/g, (whole, name) =>
    name in values ? [values[name]].flat().map(own).join(words[language].separator) : whole,
  );
}

function sayAll() {
  document.documentElement.lang = language;
  for (const one of document.querySelectorAll("[data-say]"))
    one.textContent = say(one.dataset.say, JSON.parse(one.dataset.values ?? "{}"));
  for (const one of document.querySelectorAll("[data-label]")) one.ariaLabel = say(one.dataset.label);
  for (const one of document.querySelectorAll("[data-text]")) one.textContent = own(JSON.parse(one.dataset.text));
  // Under its title a page is saved and printed.
  document.title = [...document.querySelectorAll("h1, .who")].map((one) => one.textContent).join(" – ");
  for (const button of languages.children) button.ariaPressed = String(button.lang === language);
  dispatchEvent(new Event("languagechange"));
}

const languages = document.querySelector("nav.languages");
languages.append(
  ...Object.keys(words).map((tag) => {
    const button = Object.assign(document.createElement("button"), {lang: tag, textContent: words[tag].language});
    button.addEventListener("click", () => {
      language = tag;
      sayAll();
    });
    return button;
  }),
);
sayAll();

import {type Key, say, type Words} from "../messages/say";
import {kSaid, type Said, sayIn, setWords, type SpokenPart, textNode} from "./spoken";

/// Properties of an element, of which the texts may follow the language: as functions, or by the
/// messages that fill them.
type Properties<T> = Said & {
  [Name in keyof T]?: Name extends SpokenPart ? T[Name] | (() => string) : T[Name];
};
const kSpoken: readonly SpokenPart[] = ["textContent", "title", "ariaLabel", "placeholder", "alt"];

/// Returns the element of index.html with this id; throws if page and script do not match.
export function element<T extends HTMLElement>(id: string, type: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new Error(`index.html has no ${type.name} #${id}`);
  return found;
}

/// Calls this when that button of index.html is pressed.
export function onPress(id: string, run: () => void): HTMLButtonElement {
  const button = element(id, HTMLButtonElement);
  button.addEventListener("click", run);
  return button;
}

type Tag = keyof HTMLElementTagNameMap;
type Made<Name extends string> = HTMLElementTagNameMap[(Name extends `${infer Of}.${string}`
  ? Of
  : Name) &
  Tag];
type Child = Node | Words;

/// Makes an element.
/// @param name  its tag and classes: "li", "p.quiet"
/// @param rest  its properties, if there are any, and its children
export function make<Name extends Tag | `${Tag}.${string}`>(
  name: Name,
  ...rest: [Properties<Made<Name>>, ...Child[]] | Child[]
): Made<Name> {
  const [tag, ...classes] = name.split(".");
  const made = document.createElement(tag!) as Made<Name>;
  if (classes.length > 0) made.className = classes.join(" ");
  for (const one of rest) {
    if (typeof one === "function") made.append(textNode(one));
    else if (typeof one === "string" || one instanceof Node) made.append(one);
    else setProperties(made, one);
  }
  return made;
}

function setProperties<T extends HTMLElement>(made: T, properties: Properties<T>): void {
  sayIn(made, properties);
  for (const [name, value] of Object.entries(properties)) {
    const isSpoken = kSpoken.includes(name as SpokenPart) && typeof value === "function";
    if (isSpoken) setWords(made, name as SpokenPart, value as () => string);
    else if (!(name in kSaid)) Object.assign(made, {[name]: value as unknown});
  }
}

/// A text, by its message or by a function.
export type Told = Key | (() => string);
const wordsOf = (told: Told): (() => string) => (typeof told === "string" ? () => say(told) : told);

/// Makes a button with this action.
export function press(
  text: Told,
  onclick: () => void,
  more: Properties<HTMLButtonElement> = {},
): HTMLButtonElement {
  return make("button", {type: "button", textContent: wordsOf(text), onclick, ...more});
}

/// Makes a button that asks for confirmation with this text.
export function sure(
  text: Told,
  question: Told,
  wish: () => void,
  more: Properties<HTMLButtonElement> = {},
): HTMLButtonElement {
  let isSure = false;
  const turn = (to: boolean): void => {
    isSure = to;
    setText(button, wordsOf(to ? question : text));
    button.classList.toggle("alarm", to);
  };
  const wishOrAsk = (): void => {
    if (isSure) wish();
    turn(!isSure);
  };
  const button = press(text, wishOrAsk, more);
  button.addEventListener("blur", () => turn(false));
  return button;
}

export function makeSvg<Tag extends keyof SVGElementTagNameMap>(
  tag: Tag,
  attributes: Readonly<Record<string, string>> = {},
): SVGElementTagNameMap[Tag] {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

/// Sets an element's text.
export function setText(target: Element, text: Words): void {
  setWords(target, "textContent", text);
}

/// Sets the text of an element of index.html.
export const setTextOf = (id: string, text: Words): void => setText(element(id, HTMLElement), text);

/// Makes a table.   @param heads  a text, or a cell of its own
export const table = (heads: readonly (string | Node)[], rows: readonly Node[]): HTMLTableElement =>
  make(
    "table",
    make(
      "thead",
      make(
        "tr",
        ...heads.map((one) => (typeof one === "string" ? make("th", {scope: "col"}, one) : one)),
      ),
    ),
    make("tbody", ...rows),
  );

/// Makes an option of a select.
export const option = (words: Words, value: string): HTMLOptionElement =>
  make("option", {value}, words);

/// Gives an element the children that were made anew, in place: what is focused or pressed stays.
/// Those with a key (data-key) are found by it, the others by their place.
export function refill(target: Element, ...fresh: readonly Node[]): void {
  const old = [...target.childNodes];
  const keyOf = (node: Node | undefined) => node instanceof HTMLElement && node.dataset.key;
  fresh.forEach((node, place) => {
    const key = keyOf(node);
    const had = key ? old.find((one) => keyOf(one) === key) : old[place];
    const isKept = had?.nodeName === node.nodeName && keyOf(had) === key;
    const now = isKept ? had : node;
    if (isKept && had instanceof HTMLElement) become(had, node as HTMLElement);
    else if (isKept && had.textContent !== node.textContent) had.textContent = node.textContent;
    if (target.childNodes[place] !== now)
      target.insertBefore(now, target.childNodes[place] ?? null);
  });
  while (target.childNodes.length > fresh.length) target.lastChild!.remove();
}

function become(had: HTMLElement, fresh: HTMLElement): void {
  for (const {name} of [...had.attributes])
    if (!fresh.hasAttribute(name)) had.removeAttribute(name);
  for (const {name, value} of fresh.attributes)
    if (had.getAttribute(name) !== value) had.setAttribute(name, value);
  had.onclick = fresh.onclick;
  refill(had, ...fresh.childNodes);
}

/// Sets a select's options, unless they are unchanged.
export function setOptions(
  select: HTMLSelectElement,
  options: readonly {value: string; text: string}[],
  chosen: string,
  none: string,
): void {
  const wanted = options.length > 0 ? options : [{value: "", text: none}];
  refill(select, ...wanted.map(({value, text}) => new Option(text, value)));
  if (select.value !== chosen) select.value = chosen;
  select.disabled = options.length < 2;
}

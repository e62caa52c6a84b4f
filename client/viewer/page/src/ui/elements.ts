/// Returns the element of index.html with this id; throws if page and script do not match.
export function element<T extends HTMLElement>(id: string, type: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new Error(`index.html has no ${type.name} #${id}`);
  return found;
}

/// Makes an element with these properties and children.
export function make<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  properties: Partial<HTMLElementTagNameMap[Tag]> = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[Tag] {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

/// Makes a button with this action.
export function press(
  textContent: string,
  onclick: () => void,
  more: Partial<HTMLButtonElement> = {},
): HTMLButtonElement {
  return make("button", {type: "button", textContent, onclick, ...more});
}

/// Makes a button that asks for confirmation with this text.
export function sure(
  text: string,
  question: string,
  wish: () => void,
  title = "",
): HTMLButtonElement {
  let isSure = false;
  const turn = (to: boolean): void => {
    isSure = to;
    setText(button, to ? question : text);
    button.classList.toggle("alarm", to);
  };
  const wishOrAsk = (): void => {
    if (isSure) wish();
    turn(!isSure);
  };
  const button = press(text, wishOrAsk, {title});
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

/// Changes the document only if the text differs: otherwise a screen reader would read it again.
export function setText(target: Element, text: string): void {
  if (target.textContent !== text) target.textContent = text;
}

/// Sets a select's options, unless they are unchanged.
export function setOptions(
  select: HTMLSelectElement,
  options: readonly {value: string; text: string}[],
  chosen: string,
  none: string,
): void {
  const wanted = options.length > 0 ? options : [{value: "", text: none}];
  const same =
    select.options.length === wanted.length &&
    wanted.every((option, i) => {
      const have = select.options[i]!;
      return have.value === option.value && have.text === option.text;
    });
  if (!same) select.replaceChildren(...wanted.map(({value, text}) => new Option(text, value)));
  if (select.value !== chosen) select.value = chosen;
  select.disabled = options.length < 2;
}

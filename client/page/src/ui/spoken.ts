import {type Key, say, textOf, type Words} from "../messages/say";

/// Texts that follow the page's language.  A part of the document that was filled by a function is
/// filled by it again when the language changes; nothing else of the document is touched, so what
/// was typed, scrolled and focused stays.

export type SpokenPart = "textContent" | "title" | "ariaLabel" | "placeholder" | "alt";

/// The parts that a message fills, by their names in an element's dataset (index.html) and in `make`.
export const kSaid = {
  say: "textContent",
  sayTitle: "title",
  sayLabel: "ariaLabel",
  sayPlaceholder: "placeholder",
} as const satisfies Record<string, SpokenPart>;
export type Said = {readonly [Name in keyof typeof kSaid]?: Key};

/// Fills an element's parts by messages.
export function sayIn(target: Node, said: Said): void {
  for (const [name, part] of Object.entries(kSaid)) {
    const key = said[name as keyof Said];
    if (key !== undefined) setWords(target, part, () => say(key));
  }
}

const kFilled = new WeakMap<Node, Map<SpokenPart, () => string>>();
const kFollowers: (() => void)[] = [];

/// Fills a part of an element or text node; a later string replaces an earlier function.
export function setWords(target: Node, part: SpokenPart, words: Words): void {
  const filled = kFilled.get(target);
  if (typeof words === "string") filled?.delete(part);
  else if (filled) filled.set(part, words);
  else kFilled.set(target, new Map([[part, words]]));
  fill(target, part, textOf(words));
}

/// Makes a text that stands among other nodes.
export function textNode(words: () => string): Text {
  const node = document.createTextNode("");
  setWords(node, "textContent", words);
  return node;
}

/// Calls this when the language has changed, for what is drawn as a whole: lists, tables, plots.
export function followLanguage(draw: () => void): void {
  kFollowers.push(draw);
}

/// Says everything again, in the present language.
export function sayAgain(): void {
  const walker = document.createTreeWalker(
    document.documentElement,
    NodeFilter.SHOW_ELEMENT | NodeFilter.SHOW_TEXT,
  );
  const nodes: Node[] = []; // listed first, since a text replaces its node's children
  while (walker.nextNode()) nodes.push(walker.currentNode);
  for (const node of nodes)
    for (const [part, words] of kFilled.get(node) ?? []) fill(node, part, words());
  for (const draw of kFollowers) draw();
}

/// Changes the document only if the text differs: otherwise a screen reader would read it again.
function fill(target: Node, part: SpokenPart, text: string): void {
  const filled = target as Node & Partial<Record<SpokenPart, string | null>>;
  if (filled[part] !== text) filled[part] = text;
}

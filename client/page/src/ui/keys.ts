/// Keys that scroll the panel.
const kScrolls = new Set(["Home", "End"]);
const kMovesSlider = (key: string): boolean => key.length > 1;

/// A letter, or a vowel sign that a key has, of another script than Latin; Arabic has two on a key.
const kOtherScript = /^(?!\p{Script=Latin})[\p{L}\p{M}]/u;

/// Returns the key's name, with letters in lower case.  A layout without Latin letters (Cyrillic,
/// Greek, Arabic, Thai) has the letter that the key has on others.
export function keyOf({key, code}: Pick<KeyboardEvent, "key" | "code">): string {
  const [, latin] = /^Key([A-Z])$/.exec(code) ?? [];
  if (latin !== undefined && kOtherScript.test(key)) return latin.toLowerCase();
  return key.length === 1 ? key.toLowerCase() : key;
}

/// Calls one action per key.  Keys that are typed into a control or belong to the browser are left
/// alone; scrolling keys, such as arrows, go to the focused element unless that is the picture.  A
/// slider uses no letters, so it keeps only the keys that move it.
export function listenForKeys(actions: Readonly<Record<string, () => void>>): void {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    const target = event.target;
    const isSlider = target instanceof HTMLInputElement && target.type === "range";
    if (isSlider && kMovesSlider(event.key)) return;
    if (target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && !isSlider))
      return;
    if (document.querySelector("dialog[open]")) return;
    const isFree = target === document.body || target instanceof HTMLCanvasElement;
    if (event.key.startsWith("Arrow") && !isFree) return;
    if (kScrolls.has(event.key) && target instanceof Element && target.closest(".panel")) return;
    // Space presses a focused button, and scrolls elsewhere.
    if (event.key === " " && !isFree && !isSlider) return;
    const action = actions[keyOf(event)];
    if (!action || (event.repeat && event.key === " ")) return;
    event.preventDefault();
    action();
  });
}

/// One key, one thing to do.  Keys that are typed into a control, or belong to the browser, are
/// left alone; and those that scroll, as arrows do, to whatever else than the picture has the focus.
export function listenForKeys(actions: Readonly<Record<string, () => void>>): void {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    const target = event.target;
    if (target instanceof HTMLSelectElement || target instanceof HTMLInputElement) return;
    if (document.querySelector("dialog[open]")) return;
    const isFree = target === document.body || target instanceof HTMLCanvasElement;
    if (event.key.startsWith("Arrow") && !isFree) return;
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
}

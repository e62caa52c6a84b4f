import {element} from "./elements";

/// Opens and closes the panel of figures, the help and the settings, by button and by the returned
/// keys, for listenForKeys.
export function listenToPanel(): Readonly<Record<string, () => void>> {
  const panel = element("panel", HTMLElement);
  const button = element("panel-toggle", HTMLButtonElement);
  const toggle = (): void => {
    panel.hidden = !panel.hidden;
    button.setAttribute("aria-expanded", String(!panel.hidden));
  };
  const opener = (name: string) => {
    const open = (): void => element(`${name}-dialog`, HTMLDialogElement).showModal();
    element(name, HTMLButtonElement).addEventListener("click", open);
    return open;
  };
  button.addEventListener("click", toggle);
  return {p: toggle, "?": opener("help"), o: opener("settings")};
}

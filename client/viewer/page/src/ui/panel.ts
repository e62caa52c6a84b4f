import {element} from "./elements";

/// The panel of figures and the help, by button and by the keys that it returns, for listenForKeys.
export function listenToPanel(): Readonly<Record<string, () => void>> {
  const panel = element("panel", HTMLElement);
  const button = element("panel-toggle", HTMLButtonElement);
  const toggle = (): void => {
    panel.hidden = !panel.hidden;
    button.setAttribute("aria-expanded", String(!panel.hidden));
  };
  const help = (): void => element("help-dialog", HTMLDialogElement).showModal();
  button.addEventListener("click", toggle);
  element("help", HTMLButtonElement).addEventListener("click", help);
  return {p: toggle, "?": help};
}

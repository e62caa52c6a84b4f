import {element, onPress} from "./elements";

/// Opens and closes the panel of figures, the help and the settings, by button and by the returned
/// keys, for listenForKeys.
export function listenToPanel(): Readonly<Record<string, () => void>> {
  const panel = element("panel", HTMLElement);
  const toggle = (): void => {
    panel.hidden = !panel.hidden;
    button.setAttribute("aria-expanded", String(!panel.hidden));
  };
  const button = onPress("panel-toggle", toggle);
  const opener = (name: string) => {
    const open = (): void => element(`${name}-dialog`, HTMLDialogElement).showModal();
    onPress(name, open);
    return open;
  };
  return {p: toggle, "?": opener("help"), o: opener("settings")};
}

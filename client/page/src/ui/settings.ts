import {element} from "./elements";
import {keep, recall} from "../base/kept";

/// A switch in the settings, kept for the next visit: sets a class of the same name on the page,
/// for the style sheet, and calls what else depends on it.
export function listenToSetting(
  name: "left-handed" | "projector" | "force-sound" | "bur-mute",
  changed: (on: boolean) => void = () => {},
): void {
  const box = element(name, HTMLInputElement);
  const key = `palpate-${name}`;
  const show = (): void => {
    document.documentElement.classList.toggle(name, box.checked);
    changed(box.checked);
  };
  box.checked = recall("localStorage", key) === "on";
  if (box.checked) show();
  box.addEventListener("change", () => {
    keep("localStorage", key, box.checked ? "on" : "off");
    show();
  });
}

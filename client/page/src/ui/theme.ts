import {onPress} from "./elements";
import {keep, recall} from "../base/kept";

const kThemes = ["light", "dark"] as const;
const kKey = "palpate-theme";

const kSystem = matchMedia("(prefers-color-scheme: dark)");

/// Light or dark: the system's preference, until the reader chooses.
export class ThemeSwitch {
  private chosen = kThemes.find((theme) => theme === recall("localStorage", kKey));

  constructor(private readonly changed: () => void) {
    this.apply();
    onPress("theme", () => this.toggle());
    kSystem.addEventListener("change", () => {
      this.apply();
      this.changed();
    });
  }

  toggle(): void {
    this.chosen = this.current === "dark" ? "light" : "dark";
    keep("localStorage", kKey, this.chosen);
    this.apply();
    this.changed();
  }

  private get current(): (typeof kThemes)[number] {
    return this.chosen ?? (kSystem.matches ? "dark" : "light");
  }
  private apply(): void {
    document.documentElement.dataset.theme = this.current;
  }
}

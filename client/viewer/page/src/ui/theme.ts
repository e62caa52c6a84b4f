export type Theme = "light" | "dark";
const kKey = "palpate-theme";

const kSystem = matchMedia("(prefers-color-scheme: dark)");

/// Light or dark: as the system has it, until the reader chooses.
export class ThemeSwitch {
  private chosen = remembered();

  constructor(
    button: HTMLButtonElement,
    private readonly changed: () => void,
  ) {
    this.apply();
    button.addEventListener("click", () => this.toggle());
    kSystem.addEventListener("change", () => {
      this.apply();
      this.changed();
    });
  }

  toggle(): void {
    this.chosen = this.current === "dark" ? "light" : "dark";
    remember(this.chosen);
    this.apply();
    this.changed();
  }

  private get current(): Theme {
    return this.chosen ?? (kSystem.matches ? "dark" : "light");
  }
  private apply(): void {
    document.documentElement.dataset.theme = this.current;
  }
}

// A browser that keeps nothing for this page (private windows) is no reason to fail.
function remembered(): Theme | undefined {
  try {
    const value = localStorage.getItem(kKey);
    return value === "light" || value === "dark" ? value : undefined;
  } catch {
    return undefined;
  }
}
function remember(theme: Theme): void {
  try {
    localStorage.setItem(kKey, theme);
  } catch {
    // It is kept until the page goes.
  }
}

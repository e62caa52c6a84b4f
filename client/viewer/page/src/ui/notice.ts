import {element, setText} from "./elements";

const kNewsMs = 5000;

export interface NoticeOptions {
  readonly alarm?: boolean;
  /// It is shown only as long as this holds; left out: for a few seconds.
  readonly whileSo?: () => boolean;
  readonly action?: {readonly text: string; run(): void};
}

interface Said extends NoticeOptions {
  readonly text: string;
  readonly untilMs: number;
}

/// The one line above the buttons: what has just been said, as long as it is so, and else what the
/// reader can do now.
export class Notice {
  private readonly line = element("hint", HTMLDivElement);
  private readonly text = element("hint-text", HTMLParagraphElement);
  private readonly button = element("hint-action", HTMLButtonElement);
  private said: Said | undefined;
  private help = "";

  constructor() {
    this.button.addEventListener("click", () => {
      const run = this.said?.action?.run;
      this.said = undefined;
      run?.();
      this.update(true);
    });
  }

  say(text: string, options: NoticeOptions = {}): void {
    const untilMs = options.whileSo ? Infinity : performance.now() + kNewsMs;
    this.said = {...options, text, untilMs};
    this.update(true);
  }

  /// What is shown where nothing has been said.
  rest(help: string): void {
    this.help = help;
  }

  /// @param helps  nothing worse stands above the picture than what the reader can do
  update(helps: boolean): void {
    const {said} = this;
    if (said && (performance.now() > said.untilMs || said.whileSo?.() === false)) {
      this.said = undefined;
    }
    const words = this.said?.text ?? (helps ? this.help : "");
    this.line.hidden = words === "";
    this.line.classList.toggle("alarm", this.said?.alarm ?? false);
    setText(this.text, words);
    this.button.hidden = this.said?.action === undefined;
    const action = this.said?.action?.text;
    if (action === undefined) return; // hidden, it keeps its last name
    setText(this.button, action);
    if (this.button.ariaLabel !== action) this.button.ariaLabel = action;
  }
}

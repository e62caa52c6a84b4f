import {textOf, type Words} from "../messages/say";
import {element, setText} from "./elements";

const kNewsMs = 5000;

export interface NoticeOptions {
  readonly alarm?: boolean;
  /// The message is shown while this returns true; if left out, for a few seconds.
  readonly whileSo?: () => boolean;
  readonly action?: {readonly text: Words; run(): void};
}

interface Said extends NoticeOptions {
  readonly text: Words;
  readonly untilMs: number;
}

/// The one line above the buttons: the latest message while it applies, and otherwise a hint what
/// the reader can do now.
export class Notice {
  private readonly line = element("hint", HTMLDivElement);
  private readonly text = element("hint-text", HTMLParagraphElement);
  private readonly button = element("hint-action", HTMLButtonElement);
  private said: Said | undefined;
  private help: Words = "";

  constructor() {
    this.button.addEventListener("click", () => {
      const run = this.said?.action?.run;
      this.said = undefined;
      run?.();
      this.update(true);
    });
  }

  say(text: Words, options: NoticeOptions = {}): void {
    const untilMs = options.whileSo ? Infinity : performance.now() + kNewsMs;
    this.said = {...options, text, untilMs};
    this.update(true);
  }

  /// Sets the hint that is shown if there is no message.
  rest(help: Words): void {
    this.help = help;
  }

  /// @param helps  whether the hint may be shown: there is no alarm above the picture
  update(helps: boolean): void {
    const {said} = this;
    if (said && (performance.now() > said.untilMs || said.whileSo?.() === false)) {
      this.said = undefined;
    }
    const words = textOf(this.said?.text ?? (helps ? this.help : ""));
    this.line.hidden = words === "";
    this.line.classList.toggle("alarm", this.said?.alarm ?? false);
    setText(this.text, words);
    this.button.hidden = this.said?.action === undefined;
    if (!this.said?.action) return; // hidden, it keeps its last name
    const action = textOf(this.said.action.text);
    setText(this.button, action);
    if (this.button.ariaLabel !== action) this.button.ariaLabel = action;
  }
}

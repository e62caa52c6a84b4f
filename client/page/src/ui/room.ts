import type {Key, Words} from "../messages/say";
import {element, make, press, setText} from "./elements";

/// A dialog, the button in the bar that opens it, its head (a title, what a view adds, and a button
/// that closes it), and below that a line that says what became of a request.
export class Room {
  readonly dialog: HTMLDialogElement;
  readonly title: HTMLHeadingElement;
  private readonly button: HTMLButtonElement;
  private readonly head = make("header");
  private readonly word = make("p.word", {role: "status"});

  constructor(
    name: "class" | "exam" | "exercises" | "history",
    words: {readonly open: Key; readonly openTitle: Key; readonly title: Key},
    open: () => void,
  ) {
    this.button = press(words.open, open, {
      ...{id: `${name}-open`, hidden: true, sayTitle: words.openTitle},
    });
    this.title = make("h2", {id: `${name}-title`, say: words.title});
    const close = press("class.close", () => this.dialog.close(), {className: "close"});
    this.head.append(this.title, close);
    this.dialog = make("dialog", {id: `${name}-dialog`}, this.head, this.word);
    this.dialog.setAttribute("aria-labelledby", this.title.id);
    element("audience", HTMLButtonElement).before(this.button);
    document.body.append(this.dialog);
  }

  /// Puts parts beside the title, and the rest below.
  fill(head: {readonly before?: Node; readonly after?: readonly Node[]}, ...body: Node[]): void {
    if (head.before) this.head.prepend(head.before);
    this.title.after(...(head.after ?? []));
    this.dialog.append(...body);
  }

  tell(text: Words, isAlarm = false): void {
    setText(this.word, text);
    this.word.classList.toggle("alarm", isAlarm);
  }

  get isOpen(): boolean {
    return this.dialog.open;
  }
  open(): void {
    this.dialog.showModal();
  }
  close(): void {
    this.dialog.close();
  }

  /// @param may  this page may open it
  allow(may: boolean): void {
    this.button.hidden = !may;
    if (!may && this.isOpen) this.close();
  }
}

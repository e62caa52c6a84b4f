import type {SceneWhole} from "../protocol/messages";
import {element} from "../ui/elements";
import type {Notice} from "../ui/notice";

/// Has the server make whole what has been scraped off or cut, and says what became of that.
export class WholeButton {
  private readonly button = element("whole", HTMLButtonElement);
  private asked = false;

  constructor(
    private readonly notice: Notice,
    private readonly ask: () => void,
  ) {
    this.button.addEventListener("click", () => this.press());
  }

  show(isOffered: boolean, isWhole: boolean): void {
    this.button.hidden = !isOffered;
    this.button.disabled = isWhole;
  }

  press(): void {
    if (this.button.hidden || this.button.disabled) return;
    this.asked = true;
    this.notice.say("Asking the server to make it whole…");
    this.ask();
  }

  /// @param isNews  who looks on should know why the objects have changed; who has asked, anyway
  answered({scene, by, refusal}: SceneWhole, isNews: boolean): void {
    if (!isNews && !this.asked) return;
    this.asked = false;
    const text =
      refusal === "" ? `The ${scene} is whole again (${by}).` : `It is not made whole: ${refusal}.`;
    this.notice.say(text, {alarm: refusal !== ""});
  }
}

import {say} from "../messages/say";
import {sayReason} from "../model/reasons";
import type {SceneWhole, WholeWish} from "../protocol/messages";
import {onPress} from "../ui/elements";
import type {Notice} from "../ui/notice";

/// Asks the server to restore a cut scene, or its state at a bookmark, and reports the result.
export class WholeButton {
  private readonly button = onPress("whole", () => this.press());
  private readonly bookmark = onPress("keep-cut", () => this.wish("bookmark"));
  private readonly back = onPress("back-to-cut", () => this.wish("back"));
  private asked: WholeWish | undefined;

  constructor(
    private readonly notice: Notice,
    private readonly ask: (wish: WholeWish) => void,
  ) {}

  show(isOffered: boolean, isWhole: boolean, hasBookmark: boolean): void {
    this.button.hidden = this.bookmark.hidden = this.back.hidden = !isOffered;
    this.button.disabled = isWhole;
    this.back.disabled = !hasBookmark;
  }

  press(): void {
    if (!this.button.hidden && !this.button.disabled) this.wish("whole");
  }

  private wish(wish: WholeWish): void {
    this.asked = wish;
    this.notice.say(() => say(`whole.asking_${wish}`));
    this.ask(wish);
  }

  /// @param isNews  spectators are told why the objects have changed; the page that asked
  /// is always told
  answered({scene, by, refusal, wish}: SceneWhole, isNews: boolean): void {
    if (!isNews && !this.asked) return;
    this.asked = undefined;
    if (refusal === "") this.notice.say(() => say(`whole.done_${wish}`, {scene, by}));
    else this.sayNot(wish, refusal);
  }

  /// The gateway has refused something, without asking the server.
  refused(reason: string): void {
    if (this.asked) this.sayNot(this.asked, reason);
    this.asked = undefined;
  }

  private sayNot(wish: WholeWish, reason: string): void {
    this.notice.say(() => say(`whole.not_${wish}`, {reason: sayReason(reason)}), {alarm: true});
  }
}

import {say} from "../messages/say";
import {figure} from "../model/words";
import {element, setText} from "./elements";

/// The bar extends to this multiple of the limit, so that the size of an excess shows.
const kBeyond = 1.5;
const kGravity = 9.80665; // [m/s²]

/// Shows a force against its limit, beside the picture on the hand's side.  An excess is shown by
/// the bar's length, stripes, a frame and a text, and not by colour only.
export class ForceBar {
  private readonly bar = element("force-bar", HTMLDivElement);
  private readonly now = element("force-bar-now", HTMLSpanElement);
  private readonly mass = element("force-bar-mass", HTMLSpanElement);
  private readonly limit = element("force-bar-limit", HTMLSpanElement);

  /// @param forceN  undefined: no tool moves
  /// @param limitN  undefined: there is no limit and no bar
  /// @return the message for a screen reader; empty: none
  show(forceN: number | undefined, limitN: number | undefined): string {
    const {bar} = this;
    bar.hidden = limitN === undefined;
    if (limitN === undefined) return "";
    const force = forceN ?? 0;
    const isOver = force > limitN;
    const text = (newtons: number, digits: number): string => `${figure(newtons, digits)} N`;
    const values = {force: text(force, 2), limit: text(limitN, 3)};
    bar.classList.toggle("over", isOver);
    bar.style.setProperty("--share", Math.min(1, force / (kBeyond * limitN)).toFixed(3));
    bar.ariaValueMax = String(kBeyond * limitN);
    bar.ariaValueNow = force.toFixed(2);
    const words = say(isOver ? "force_bar.over" : "force_bar.under", values);
    bar.ariaValueText = words;
    setText(this.now, forceN === undefined ? "–" : values.force);
    setText(this.mass, `${figure((1000 * limitN) / kGravity, 0)} g`);
    setText(this.limit, values.limit);
    return isOver ? words : "";
  }
}

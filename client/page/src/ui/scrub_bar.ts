import {clock, gapWords, markWords} from "../model/words";
import {
  kMarkKinds,
  type MarkKind,
  type ReplayContents,
  type ReplayGap,
  type ReplayMark,
} from "../protocol/messages";
import {element, makeSvg, setText} from "./elements";

/// Width of the marks' drawing, as in index.html.
const kWide = 1000;
/// A pointer this near a mark selects it [px].
const kNearPx = 7;
/// A drag that has stood still for longer than this no longer matches the replay's position [s].
const kHeldS = 0.3;
const kArrowS = 1;
const kPageS = 10;

/// The bar of a replay's time, with its marks, gaps and position.
export class ScrubBar {
  private readonly bar = element("scrub-bar", HTMLDivElement);
  private readonly input = element("scrub", HTMLInputElement);
  private readonly tip = element("scrub-tip", HTMLSpanElement);
  private readonly picture = document.getElementById("scrub-marks")!;
  private marks: readonly ReplayMark[] = [];
  private gaps: readonly ReplayGap[] = [];
  private lengthS = 1;
  private dragging = false;
  private movedS = -Infinity;

  constructor(private readonly sought: (atS: number) => void) {
    const {input} = this;
    input.addEventListener("pointerdown", () => (this.dragging = true));
    input.addEventListener("input", () => {
      this.movedS = performance.now() / 1000;
      this.fill();
      this.showTip(Number(input.value));
      this.sought(Number(input.value));
    });
    input.addEventListener("change", () => {
      const heldS = performance.now() / 1000 - this.movedS;
      if (this.dragging && heldS > kHeldS) this.sought(Number(input.value));
      this.dragging = false;
    });
    for (const end of ["pointerup", "pointercancel", "blur"]) {
      // After `change`, which is the last event.
      input.addEventListener(end, () => window.setTimeout(() => this.letGo()));
    }
    input.addEventListener("pointermove", (event) => {
      if (!this.dragging) this.showTip(this.timeAt(event.clientX));
    });
    input.addEventListener("pointerleave", () => {
      if (!this.dragging) this.tip.hidden = true;
    });
    input.addEventListener("keydown", (event) => this.key(event));
  }

  setContents(contents: ReplayContents, lengthS: number): void {
    this.marks = contents.marks;
    this.gaps = contents.gaps;
    this.lengthS = Math.max(lengthS, 1e-3);
    this.input.max = String(this.lengthS);
    const x = (atS: number): number => (kWide * atS) / this.lengthS;
    const shapes = contents.gaps.map(({fromS, toS}) =>
      makeSvg("rect", {
        class: "gap",
        x: x(fromS).toFixed(2),
        width: Math.max(0.5, x(toS) - x(fromS)).toFixed(2),
        y: "36",
        height: "28",
      }),
    );
    const path = (name: string, kind: MarkKind, line: string): SVGPathElement => {
      const all = this.marks.filter((mark) => mark.kind === kind);
      const d = all.map(({atS}) => `M${x(atS).toFixed(2)} ${line}`).join("");
      return makeSvg("path", {class: `mark ${name}`, d});
    };
    // One path per kind, however many marks: bookmarks above the bar and on top.
    const paths = [...kMarkKinds]
      .reverse()
      .map((kind) => path(kind, kind, kind === "bookmark" ? "8V64" : "36V92"));
    const heads = path("bookmark head", "bookmark", "14h0");
    this.picture.replaceChildren(...shapes, ...paths, heads);
  }

  /// While the reader drags, the thumb stays there.
  show(atS: number, words: string): void {
    if (!this.dragging) this.input.value = String(atS);
    this.input.setAttribute("aria-valuetext", words);
    this.fill();
  }

  private fill(): void {
    const done = Number(this.input.value) / this.lengthS;
    this.bar.style.setProperty("--done", done.toFixed(4));
  }

  private letGo(): void {
    this.dragging = false;
    this.tip.hidden = true;
  }

  private key(event: KeyboardEvent): void {
    const steps: Readonly<Record<string, number>> = {
      ArrowLeft: -kArrowS,
      ArrowDown: -kArrowS,
      ArrowRight: kArrowS,
      ArrowUp: kArrowS,
      PageDown: -kPageS,
      PageUp: kPageS,
      Home: -Infinity,
      End: Infinity,
    };
    const step = steps[event.key];
    if (step === undefined || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    this.sought(Math.min(Math.max(0, Number(this.input.value) + step), this.lengthS));
  }

  /// The thumb's centre moves from half its width to as much before the end.
  private timeAt(clientX: number): number {
    const {left, width} = this.picture.getBoundingClientRect();
    return Math.min(Math.max(0, (clientX - left) / width), 1) * this.lengthS;
  }

  private showTip(atS: number): void {
    const {left, width} = this.picture.getBoundingClientRect();
    const nearS = (kNearPx / Math.max(1, width)) * this.lengthS;
    const near = this.marks
      .filter((mark) => Math.abs(mark.atS - atS) <= nearS)
      .sort((a, b) => Math.abs(a.atS - atS) - Math.abs(b.atS - atS))[0];
    const gap = this.gaps.find(({fromS, toS}) => fromS <= atS && atS < toS);
    const what = near ? markWords(near) : gap ? gapWords(gap) : "";
    const time = clock(near?.atS ?? atS);
    setText(this.tip, what === "" ? time : `${time} · ${what}`);
    this.tip.hidden = false;
    const box = this.bar.getBoundingClientRect();
    const x = left - box.left + (atS / this.lengthS) * width;
    const half = this.tip.offsetWidth / 2;
    this.tip.style.left = `${Math.min(Math.max(half, x), box.width - half)}px`;
  }
}

import {say, sayList} from "../messages/say";
import {Ladder} from "./ladder";
import {percent} from "./words";

/// The quality of pictures.  There are two ladders because, without a graphics card, a picture in
/// which only tools move costs a tenth of a full redraw.

export const kQualities = ["full", "good", "fair", "low"] as const;
export type Quality = (typeof kQualities)[number];

/// How pictures are drawn while the camera moves or the objects are cut.
export interface InMotion {
  readonly canvas: number; // share of the screen's pixels, per side
  readonly share: number; // likewise for the objects, which the canvas then shows enlarged
  readonly samples: number; // samples per pixel; 0: no antialiasing
  readonly detail: number; // 0: all triangles; else 1 + index into kDetails
}

/// Share of the screen's pixels, per side.
const kAtRest: readonly number[] = [1, 0.8, 0.65, 0.5];
const kInMotion: readonly InMotion[] = [
  {canvas: 1, share: 1, samples: 4, detail: 0},
  {canvas: 1, share: 1, samples: 0, detail: 1},
  {canvas: 0.8, share: 0.6, samples: 0, detail: 1},
  {canvas: 0.5, share: 0.3, samples: 0, detail: 2},
];
/// Largest error of a coarser surface, as a share of the viewed radius: one and four pixels if
/// that fills 500.
export const kDetails: readonly number[] = [0.004, 0.016];

/// What was drawn: only tools moved, or the objects too; "else": it tells nothing about the speed.
export type Drawn = "tools" | "objects" | "else";

export const qualityOf = (text: string): Quality | undefined =>
  kQualities.find((name) => name === text);

export class PictureQuality {
  private readonly rest: Ladder;
  private readonly motion: Ladder;
  private before: Drawn = "else";

  /// @param slow  there is no graphics card: camera motion starts at the lowest quality
  constructor(
    slow: boolean,
    public fixed: Quality | undefined,
  ) {
    this.rest = new Ladder(kQualities.length);
    this.motion = new Ladder(kQualities.length, slow ? kQualities.length - 1 : 0);
  }

  get share(): number {
    return kAtRest[this.rungOf(this.rest)]!;
  }
  /// Never more pixels than at rest.
  get inMotion(): InMotion {
    const {canvas, share, ...rest} = kInMotion[this.rungOf(this.motion)]!;
    const least = (one: number): number => Math.min(one, this.share);
    return {canvas: least(canvas), share: least(share), ...rest};
  }
  /// Whether the picture shows depth by shadows: what is too slow with the fewest pixels leaves
  /// them out.
  get cues(): boolean {
    return this.rungOf(this.rest) < kQualities.length - 1;
  }
  get names(): {rest: Quality; motion: Quality} {
    return {
      rest: kQualities[this.rungOf(this.rest)]!,
      motion: kQualities[this.rungOf(this.motion)]!,
    };
  }

  /// Another scene is shown.
  restart(): void {
    this.rest.restart();
    this.motion.restart();
    this.before = "else";
  }

  /// @param ms  from this picture until the browser was ready for the next.
  /// @return whether the quality has changed
  took(drawn: Drawn, ms: number): boolean {
    // A graphics card works on one picture while the next is prepared: the time may belong
    // to the former.
    const tells = drawn === this.before;
    this.before = drawn;
    if (!tells || drawn === "else" || this.fixed) return false;
    return (drawn === "tools" ? this.rest : this.motion).took(ms);
  }

  private rungOf(ladder: Ladder): number {
    return this.fixed ? kQualities.indexOf(this.fixed) : ladder.rung;
  }
}

/// Describes the quality to the reader.
export function qualityWords(quality: PictureQuality): string {
  const {rest, motion} = quality.names;
  const {canvas, share, samples, detail} = quality.inMotion;
  const pixels = (of: number): string =>
    of === 1 ? say("quality.all_pixels") : say("quality.share_of_pixels", {share: percent(of)});
  const less = sayList("list.separator", [
    canvas < quality.share ? pixels(canvas) : "",
    share < canvas ? say("quality.objects", {share: percent(share)}) : "",
    samples === 0 ? say("quality.rougher") : "",
    detail > 0 ? say("quality.fewer") : "",
  ]);
  return say("quality.words", {
    rest: say(`quality.${rest}`),
    pixels: pixels(quality.share),
    motion: say(`quality.${motion}`),
    turning: less || say("quality.as_at_rest"),
  });
}

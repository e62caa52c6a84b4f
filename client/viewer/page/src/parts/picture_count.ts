import type {Drawn} from "../model/quality";

const kWarmUp = 3;

/// How many pictures have been drawn, and what they cost.
export class PictureCount {
  pictures = 0;
  drawnAnew = 0; // times that what stands still was drawn
  firstPictureMs: number | undefined; // since the page was asked for
  private took = {last: 0, total: 0, max: 0};

  /// @param startMs  when its drawing began
  add(drawn: Drawn, startMs: number): void {
    const {took} = this;
    took.last = performance.now() - startMs;
    this.pictures += 1;
    this.drawnAnew += drawn === "tools" ? 0 : 1;
    // The first pictures upload meshes and compile shaders: once, and not what a picture costs.
    if (this.pictures > kWarmUp) {
      took.total += took.last;
      took.max = Math.max(took.max, took.last);
    }
    if (this.firstPictureMs === undefined) {
      this.firstPictureMs = performance.now();
      performance.mark("palpate-first-picture");
    }
  }

  /// Of a picture, without the card's time.
  get scriptMs(): {last: number; mean: number; max: number} {
    const {last, total, max} = this.took;
    return {last, mean: total / Math.max(1, this.pictures - kWarmUp), max};
  }
}

import type {WebGLRenderer} from "three";

import type {PictureQuality} from "../model/quality";

/// Phones with three pixels per point would draw nine times as much without visible gain.
const kMostPixelsPerPoint = 2;

/// The size of the picture's canvas, in points of the page and in pixels.
export class CanvasSize {
  private mayHaveChanged = true;
  private sized = "";
  // [points], [points], pixels per point and side
  private screen = {width: 1, height: 1, pixels: 1};
  private share = 0; // share of the screen's pixels; 0: not sized yet

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly quality: PictureQuality,
  ) {}

  /// The canvas, or its pixels at rest, may have another size.
  mayChange(): void {
    this.mayHaveChanged = true;
  }

  hasChanged(): boolean {
    if (!this.mayHaveChanged) return false;
    this.mayHaveChanged = false;
    const {clientWidth: width, clientHeight: height} = this.canvas;
    if (width === 0 || height === 0) return false;
    const pixels = Math.min(devicePixelRatio, kMostPixelsPerPoint);
    const sized = `${width} ${height} ${pixels} ${this.quality.share}`;
    if (sized === this.sized) return false;
    this.sized = sized;
    this.screen = {width, height, pixels};
    this.share = 0;
    return true;
  }

  /// Only together with a picture: resizing empties a canvas.
  /// @param share  of the screen's pixels, per side
  apply(renderer: WebGLRenderer, share: number): void {
    if (share === this.share) return;
    this.share = share;
    const {width, height, pixels} = this.screen;
    renderer.setDrawingBufferSize(width, height, share * pixels);
  }
}

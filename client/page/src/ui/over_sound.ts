import {heard} from "./bur_sound";

const kHz = 660;
const kLoudness = 0.2;
const kFadeS = 0.02; // short, but long enough to avoid a click

/// A tone while the force exceeds its limit, if the reader has enabled it.
export class OverSound {
  private wanted = false;
  private context: AudioContext | undefined;
  private gain: GainNode | undefined;

  constructor() {
    // Browsers allow sound only after the reader has interacted with the page.
    for (const event of ["pointerdown", "keydown"]) addEventListener(event, () => this.begin());
  }

  want(on: boolean): void {
    this.wanted = on;
    this.begin();
    this.update(false);
  }

  update(isOver: boolean): void {
    const loudness = isOver && this.wanted ? kLoudness : 0;
    this.gain?.gain.setTargetAtTime(loudness, this.context!.currentTime, kFadeS);
  }

  private begin(): void {
    if (!this.wanted) return;
    this.context ??= new AudioContext();
    const tone = {type: "triangle", frequency: kHz} as const;
    this.gain ??= heard(this.context, new OscillatorNode(this.context, tone));
    void this.context.resume();
  }
}

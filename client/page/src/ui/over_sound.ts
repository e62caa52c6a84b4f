const kHz = 660;
const kLoudness = 0.2;
const kFadeS = 0.02; // short, but long enough to avoid a click

/// A tone while the force exceeds its limit, if the reader has enabled it.
export class OverSound {
  private wanted = false;
  private sounds = false;
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
    const sounds = isOver && this.wanted;
    if (!this.context || sounds === this.sounds) return;
    this.sounds = sounds;
    this.gain?.gain.setTargetAtTime(sounds ? kLoudness : 0, this.context.currentTime, kFadeS);
  }

  private begin(): void {
    if (!this.wanted) return;
    if (!this.context) {
      this.context = new AudioContext();
      this.gain = new GainNode(this.context, {gain: 0});
      this.gain.connect(this.context.destination);
      const tone = new OscillatorNode(this.context, {type: "triangle", frequency: kHz});
      tone.connect(this.gain);
      tone.start();
    }
    void this.context.resume();
  }
}

const kHz = 660;
const kLoudness = 0.2;
const kFadeS = 0.02; // at once, without a click

/// A tone as long as the force is beyond its limit, where the reader wants one.
export class OverSound {
  private wanted = false;
  private sounds = false;
  private context: AudioContext | undefined;
  private gain: GainNode | undefined;

  constructor() {
    // Browsers let a page sound only once its reader has done something on it.
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

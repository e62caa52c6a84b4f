/// Force at which the sound is fullest [N].
const kFullN = 2;
/// Of a turbine, idle and under load; tuned by ear.
const kIdleHz = 880;
const kLoadedHz = 610;
const kIdleGain = 0.012;
const kLoadedGain = 0.05;
const kNoiseGain = 0.12;
const kFollowsS = 0.06;

/// The sound of a bur that turns: under load it is lower and louder, and grates.
export class BurSound {
  mute = false;
  private parts:
    | {context: AudioContext; tone: OscillatorNode; hum: GainNode; grate: GainNode}
    | undefined;

  /// @param forceN  undefined: it does not turn
  update(forceN: number | undefined): void {
    if (!this.parts && (forceN === undefined || this.mute)) return;
    this.parts ??= this.make();
    const {context, tone, hum, grate} = this.parts;
    const turns = forceN !== undefined && !this.mute;
    const load = turns ? Math.min(1, forceN / kFullN) : 0;
    const follow = (what: AudioParam, value: number): void =>
      void what.setTargetAtTime(value, context.currentTime, kFollowsS);
    follow(tone.frequency, kIdleHz + (kLoadedHz - kIdleHz) * load);
    follow(hum.gain, turns ? kIdleGain + (kLoadedGain - kIdleGain) * load : 0);
    follow(grate.gain, kNoiseGain * load);
  }

  /// After the pedal: browsers allow sound only once the reader has done something.
  private make(): NonNullable<BurSound["parts"]> {
    const context = new AudioContext();
    const tone = new OscillatorNode(context, {type: "sawtooth", frequency: kIdleHz});
    const dull = new BiquadFilterNode(context, {type: "bandpass", frequency: 1600, Q: 0.6});
    const noise = new AudioBuffer({length: context.sampleRate, sampleRate: context.sampleRate});
    noise.getChannelData(0).forEach((_, i, to) => (to[i] = 2 * Math.random() - 1));
    const rush = new AudioBufferSourceNode(context, {buffer: noise, loop: true});
    const band = new BiquadFilterNode(context, {type: "bandpass", frequency: 2400, Q: 0.8});
    const [hum, grate] = [heard(context, tone, dull), heard(context, rush, band)];
    void context.resume();
    return {context, tone, hum, grate};
  }
}

/// Starts a source whose loudness is that of the gain, none at first.
export function heard(
  context: AudioContext,
  source: AudioScheduledSourceNode,
  filter?: AudioNode,
): GainNode {
  const gain = new GainNode(context, {gain: 0});
  gain.connect(context.destination);
  (filter ? source.connect(filter) : source).connect(gain);
  source.start();
  return gain;
}

import type {Replay, ReplayPhase} from "../model/replay";
import {kTopics, type Station} from "../model/world";
import type {ReplayAnswer} from "../protocol/messages";
import type {Notice} from "../ui/notice";
import type {PlotTime} from "../ui/plots";
import {ReplayControls} from "../ui/replay_controls";
import type {GatewayLink} from "./gateway_link";
import {nowS} from "./now";

/// Whether what is seen is a replay, and what steers it.
export class ReplayMode {
  isOn = false;
  private readonly controls: ReplayControls;

  /// @param switched  on or off
  constructor(
    private readonly replay: Replay,
    private readonly link: GatewayLink,
    notice: Notice,
    private readonly switched: () => void,
  ) {
    this.controls = new ReplayControls(replay, {
      publish: (message) => link.publish(kTopics.replay, message),
      say: (text, alarm) => notice.say(text, {alarm}),
    });
  }

  /// Keys, for listenForKeys.
  get keys(): Readonly<Record<string, () => void>> {
    return this.controls.keys;
  }
  get phase(): ReplayPhase {
    return this.replay.phase(nowS(), this.link.heardSinceS);
  }

  answered(answer: ReplayAnswer): void {
    this.controls.answered(answer);
  }

  /// The replayer has spoken.
  told(): void {
    const {state} = this.replay;
    if (state) this.controls.told(state);
    this.show(nowS());
  }

  show(nowS: number): void {
    const {phase} = this;
    if ((phase !== "none") !== this.isOn) {
      this.isOn = phase !== "none";
      this.switched();
    }
    this.controls.show(phase, this.link.may.steer, nowS);
  }

  /// Figures of a replay stand at the recording's time, with what it lacks of their station.
  plotTime(station: Station | undefined, nowS: number): PlotTime {
    const {replay} = this;
    if (!this.isOn) return {nowS, isRecorded: false, gaps: []};
    const gaps = replay.contents?.gaps.filter((gap) => gap.station === station?.id) ?? [];
    return {nowS: replay.atS(nowS), isRecorded: true, gaps};
  }
}

import {say} from "../messages/say";
import {kHereS, markAfter, markBefore, type Replay, type ReplayPhase} from "../model/replay";
import {sayReason} from "../model/reasons";
import {type Wish, Wishes} from "../model/wishes";
import {clock, markWords, percent, recordedWhen, spokenTime} from "../model/words";
import type {Station} from "../model/station";
import type {ReplayAnswer, ReplayContents} from "../protocol/messages";
import {BookmarkDialog} from "../ui/bookmark_dialog";
import {element, onPress, setOptions, setText, setTextOf} from "../ui/elements";
import {MarkList} from "../ui/mark_list";
import type {Notice} from "../ui/notice";
import type {PlotTime} from "../ui/plots";
import {ScrubBar} from "../ui/scrub_bar";
import {followLanguage} from "../ui/spoken";
import type {GatewayLink} from "./gateway_link";
import {nowS} from "./now";

/// The rates that a replayer accepts (client/replayer/play/steering.cpp).
const kRates = [0.1, 0.25, 0.5, 1, 2, 4, 8];
/// If the replayer is there sooner, no message is shown.
const kSeekShownAfterS = 0.5;

/// The replay controls: the sign that a replay is shown, and its bar, buttons, keys and
/// list of marks.
export class ReplayMode {
  isOn = false;
  private readonly sign = element("replay-sign", HTMLParagraphElement);
  private readonly name = element("replay-name", HTMLSpanElement);
  private readonly controls = element("replay-controls", HTMLDivElement);
  private readonly help = element("replay-keys", HTMLElement);
  private readonly playButton = onPress("play", () => this.playOrPause());
  private readonly after = onPress("mark-after", () => this.toMarkAfter());
  private readonly rate = element("rate", HTMLSelectElement);
  private readonly bookmark: BookmarkDialog;
  private readonly bar: ScrubBar;
  private readonly list: MarkList;
  private readonly wishes: Wishes;
  private of = ""; // the replay that they belong to
  private shown: ReplayContents | undefined;
  private steers = false;
  private nowS = 0;
  private seekingSinceS: number | undefined;

  /// @param switched  called when a replay begins or ends
  constructor(
    private readonly replay: Replay,
    private readonly link: GatewayLink,
    notice: Notice,
    private readonly switched: () => void,
  ) {
    this.wishes = new Wishes(
      (message) => link.publish("replay", message),
      (_wish, reason) =>
        notice.say(() => say("replay.not_done", {reason: sayReason(reason)}), {alarm: true}),
    );
    followLanguage(() => void (this.shown = undefined)); // the marks are listed again
    this.bar = new ScrubBar((atS) => this.seek(atS));
    this.list = new MarkList(
      (mark) => this.seek(mark.atS),
      (mark) => this.ask({wish: "drop_bookmark", value: mark.number}),
    );
    this.bookmark = new BookmarkDialog((atS, text) =>
      this.ask({wish: "add_bookmark", value: atS, text}),
    );
    onPress("mark-before", () => this.toMarkBefore());
    this.rate.addEventListener("change", () => this.setRate(Number(this.rate.value)));
    onPress("bookmark", () => this.nameBookmark());
  }

  /// Keys, for listenForKeys.
  readonly keys: Readonly<Record<string, () => void>> = {
    " ": () => this.playOrPause(),
    ",": () => this.toMarkBefore(),
    ".": () => this.toMarkAfter(),
    Home: () => this.seek(0),
    End: () => this.seek(this.replay.lengthS),
    "<": () => this.nextRate(-1),
    ">": () => this.nextRate(1),
    b: () => this.nameBookmark(),
  };

  answered(answer: ReplayAnswer): void {
    this.wishes.answered(answer);
  }

  get phase(): ReplayPhase {
    return this.replay.phase(nowS(), this.link.heardSinceS);
  }

  /// Called when the replayer has sent a message.
  told(): void {
    const {state} = this.replay;
    if (state && state.replay !== this.of) {
      this.of = state.replay;
      this.wishes.clear();
    }
    if (state) this.wishes.told(state);
    this.show(nowS());
  }

  /// Plots of a replay use recorded time, with the recording's gaps for their station.
  plotTime(station: Station | undefined, now: number): PlotTime {
    const {replay} = this;
    if (!this.isOn) return {nowS: now, isRecorded: false, gaps: []};
    const gaps = replay.contents?.gaps.filter((gap) => gap.station === station?.id) ?? [];
    return {nowS: replay.atS(now), isRecorded: true, gaps};
  }

  show(now: number): void {
    const {phase} = this;
    const isThere = phase !== "none";
    if (isThere !== this.isOn) {
      this.isOn = isThere;
      this.switched();
    }
    this.nowS = now;
    this.steers = this.link.may.steer && this.replay.isSteered(now) && isThere;
    this.wishes.flush(this.of, now);
    this.sign.hidden = !isThere;
    this.controls.hidden = !this.steers;
    this.help.hidden = !this.steers;
    if (!this.steers) this.bookmark.close();
    this.list.setVisible(this.steers);
    if (!isThere) return;
    this.showSign(phase);
    if (this.steers) this.showControls();
  }

  private showSign(phase: ReplayPhase): void {
    const contents = this.replay.contents;
    this.sign.dataset.phase = phase;
    const isMoving = phase === "playing" || phase === "none";
    setTextOf("replay-word", say(isMoving ? "replay.word" : `replay.${phase}`));
    setText(this.name, contents?.recording ?? "");
    this.name.title = contents?.recording ?? "";
    setTextOf("replay-when", contents ? recordedWhen(contents.begunS) : "");
    setTextOf("replay-time", this.timeWords());
  }

  private showControls(): void {
    const contents = this.replay.contents!;
    if (contents !== this.shown) {
      this.shown = contents;
      this.bar.setContents(contents, this.replay.lengthS);
      this.list.setMarks(contents.marks);
    }
    const atS = this.atS;
    const length = spokenTime(this.replay.lengthS);
    this.bar.show(atS, say("replay.at_of", {at: spokenTime(atS), length}));
    this.list.show(atS);
    const playing = this.isPlaying;
    this.playButton.classList.toggle("playing", playing);
    this.playButton.setAttribute("aria-label", say(playing ? "replay.pause" : "replay.play"));
    this.after.disabled = markAfter(contents.marks, atS) === undefined;
    const rate = this.rateNow;
    const rates = [...new Set([...kRates, rate])].sort((a, b) => a - b);
    const options = rates.map((value) => ({value: String(value), text: `${value} ×`}));
    setOptions(this.rate, options, String(rate), "");
    const passed = contents.marks.filter((mark) => mark.atS <= atS + kHereS).at(-1);
    setTextOf("replay-where", passed ? markWords(passed) : "");
  }

  /// The position, or the progress towards the one requested.
  private timeWords(): string {
    const sought = this.replay.state?.sought ?? 1;
    const isSeeking = this.wishes.soughtS !== undefined || sought < 1;
    if (!isSeeking) this.seekingSinceS = undefined;
    else this.seekingSinceS ??= this.nowS;
    const at = clock(this.atS);
    if (this.seekingSinceS === undefined || this.nowS - this.seekingSinceS < kSeekShownAfterS) {
      return `${at} / ${clock(this.replay.lengthS)}`;
    }
    const share = percent(Math.floor(100 * sought) / 100);
    return sought < 1 ? say("replay.seeking", {at, share}) : say("replay.seeking_soon", {at});
  }

  // A requested position is shown as if reached, since the replay's answer takes time.
  private get atS(): number {
    return this.wishes.soughtS ?? this.replay.atS(this.nowS);
  }
  private get isPlaying(): boolean {
    return this.wishes.playing ?? this.replay.state?.playing ?? false;
  }
  private get rateNow(): number {
    return this.wishes.rate ?? this.replay.state?.rate ?? 1;
  }

  // --- requests ---

  private ask(wish: Wish): void {
    if (!this.steers) return;
    this.wishes.ask(this.of, wish, nowS());
    this.showControls();
  }
  private playOrPause(): void {
    this.ask({wish: this.isPlaying ? "pause" : "play"});
  }
  private seek(atS: number): void {
    this.ask({wish: "seek", value: Math.min(Math.max(0, atS), this.replay.lengthS)});
  }
  private toMarkBefore(): void {
    const marks = this.replay.contents?.marks ?? [];
    // A position that is only requested does not advance meanwhile.
    const rate = this.isPlaying && this.wishes.soughtS === undefined ? this.rateNow : 0;
    this.seek(markBefore(marks, this.atS, rate)?.atS ?? 0);
  }
  private toMarkAfter(): void {
    const mark = markAfter(this.replay.contents?.marks ?? [], this.atS);
    if (mark) this.seek(mark.atS);
  }
  private setRate(rate: number): void {
    this.ask({wish: "rate", value: rate});
  }
  private nextRate(by: 1 | -1): void {
    const rate = this.rateNow;
    const next =
      by > 0 ? kRates.find((value) => value > rate) : kRates.filter((value) => value < rate).at(-1);
    if (next !== undefined) this.setRate(next);
  }

  /// The bookmark is for the moment of the request, however long its naming takes.
  private nameBookmark(): void {
    if (this.steers) this.bookmark.open(this.atS);
  }
}

import type {SceneModel} from "../model/bundle";
import {norm} from "../model/pose";
import {probingDepthM, tellsProbingDepth} from "../model/probing";
import {touchedObjects} from "../model/touched";
import {figure, handPastM, statusSentence, stationNote, touchedWords} from "../model/words";
import type {Station} from "../model/world";
import {element, setText} from "./elements";

/// The figures above the picture: of one station, now.
export class Readout {
  readonly box = element("readout", HTMLDivElement);
  private readonly force = element("force", HTMLOutputElement);
  private readonly torque = element("torque", HTMLOutputElement);
  private readonly past = element("past", HTMLOutputElement);
  private readonly contacts = element("contacts", HTMLOutputElement);
  private readonly touched = element("touched", HTMLOutputElement);
  private readonly probing = element("probing", HTMLOutputElement);
  private readonly probingBox = element("probing-box", HTMLDivElement);
  private readonly sentence = element("sentence", HTMLParagraphElement);
  private readonly note = element("station-note", HTMLParagraphElement);

  /// @param own  the station that this page's mouse is; empty: none
  /// @return the sentence that says it to who does not see it
  show(
    station: Station | undefined,
    own: string,
    model: SceneModel | undefined,
    nowS: number,
  ): string {
    const state = station?.isMoving(nowS) ? station.track.latest : undefined;
    this.box.classList.toggle("idle", state === undefined);
    setText(this.force, state ? figure(norm(state.forceN)) : "–");
    setText(this.torque, state ? figure(1000 * norm(state.torqueNm), 1) : "–");
    setText(this.past, state ? figure(1000 * handPastM(state)) : "–");
    setText(this.contacts, state ? String(state.contacts) : "–");
    const touches = state && model ? touchedObjects(model, state.points) : [];
    setText(this.touched, state ? touchedWords(touches) : "–");
    const [tool] = model?.tools ?? [];
    const name = state?.tool ?? tool?.name ?? "";
    const tells = model !== undefined && tellsProbingDepth(model, name);
    this.probingBox.hidden = !tells;
    const depthM = tells && state ? probingDepthM(model, state.graphic) : undefined;
    setText(this.probing, depthM === undefined ? "–" : figure(1000 * depthM, 1));
    const note = stationNote(station?.session, station !== undefined && station.id === own);
    setText(this.note, note);
    this.note.hidden = note === "";
    const sentence = [statusSentence(state, depthM), note].filter((one) => one !== "").join(" ");
    setText(this.sentence, statusSentence(state)); // the figure beside it tells the depth
    return sentence;
  }
}

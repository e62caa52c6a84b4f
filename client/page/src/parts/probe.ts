import type {World} from "../model/world";
import type {LinkState} from "../protocol/connection";
import type {ToolState} from "../protocol/messages";
import type {PictureProbe} from "./picture";

type StationProbes = Record<string, ToolState & {frames: number}>;

/// What tests and curious users can read: `palpate` in the browser's console.
export interface Probe extends PictureProbe {
  link: LinkState;
  links: number; // number of times the link was opened
  scene: string;
  stations: StationProbes;
  hold: string;
}

export function probeStations(stations: World["stations"]): StationProbes {
  const probes: StationProbes = {};
  for (const [id, {track, frames}] of stations) {
    if (track.latest) probes[id] = {...track.latest, frames};
  }
  return probes;
}

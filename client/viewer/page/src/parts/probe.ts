import type {Pose, Vec3} from "../model/pose";
import type {World} from "../model/world";
import type {LinkState} from "../protocol/connection";
import type {PictureProbe} from "./picture";

type StationProbes = Record<
  string,
  {poseSequence: number; haptic: Pose; graphic: Pose; forceN: Vec3; frames: number}
>;

/// What tests and curious people can read: `palpate` in the browser's console.
export interface Probe extends PictureProbe {
  link: LinkState;
  links: number; // times that the link was opened
  scene: string;
  stations: StationProbes;
  hold: string;
}

export function probeStations(stations: World["stations"]): StationProbes {
  const probes: StationProbes = {};
  for (const [id, {track, frames}] of stations) {
    const latest = track.latest;
    if (!latest) continue;
    const {poseSequence, haptic, graphic, forceN} = latest;
    probes[id] = {poseSequence, haptic, graphic, forceN, frames};
  }
  return probes;
}

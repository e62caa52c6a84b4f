import {nameOf} from "../model/names";
import {say} from "../messages/say";
import type {Station} from "../model/station";
import type {World} from "../model/world";
import {rememberInAddress} from "../ui/address";
import {element, setOptions} from "../ui/elements";

const chosen = (name: string): string => new URLSearchParams(location.search).get(name) ?? "";

/// Which scene and which station are shown: the reader's choice, if there is one.
export class Choice {
  scene = "";
  private chosenScene = chosen("scene");
  private chosenStation = chosen("station");
  private readonly scenePick = element("scene", HTMLSelectElement);
  private readonly stationPick = element("station", HTMLSelectElement);

  constructor(
    private readonly world: World,
    private readonly entered: (scene: string) => void,
  ) {
    this.scenePick.addEventListener("change", () => {
      this.chosenScene = this.scenePick.value;
      this.chosenStation = "";
      this.chooseScene();
      rememberInAddress("scene", this.chosenScene);
    });
    this.stationPick.addEventListener("change", () => {
      this.chosenStation = this.stationPick.value;
      rememberInAddress("station", this.chosenStation);
    });
  }

  /// Chooses the reader's scene if the gateway has it, else the present one, else the first.
  chooseScene(): void {
    const known = this.world.scenes;
    const wanted = [this.chosenScene, this.scene, ...known].find((name) => known.has(name));
    if (wanted !== undefined && wanted !== this.scene) this.enter(wanted);
  }

  goWhereSomethingMoves(nowS: number): void {
    if (this.world.scenes.has(this.chosenScene) || this.stationsHere(nowS).length > 0) return;
    const mover = this.world.listed(nowS).find((station) => station.isMoving(nowS));
    if (mover && this.world.scenes.has(mover.scene)) this.enter(mover.scene);
  }

  /// Chooses as if the reader had done so.
  show(scene: string, station: string): void {
    this.chosenScene = scene;
    this.chosenStation = station;
    this.chooseScene();
    rememberInAddress("scene", scene);
    rememberInAddress("station", station);
  }

  /// Stays in this scene even if a tool moves elsewhere, with no station chosen.
  stay(): void {
    this.chosenScene = this.scene;
    this.chosenStation = "";
  }

  /// Returns the station whose figures are shown: the reader's choice, else the page's own, else
  /// one that moves.
  station(own: string, nowS: number): Station | undefined {
    const here = this.stationsHere(nowS);
    return (
      here.find(({id}) => id === this.chosenStation) ?? here.find(({id}) => id === own) ?? here[0]
    );
  }

  showLists(station: Station | undefined, nowS: number): void {
    const scenes = [...this.world.scenes].sort();
    const stations = this.stationsHere(nowS).map(({id}) => id);
    const options = (all: string[], text = (one: string): string => one) =>
      all.map((value) => ({value, text: text(value)}));
    setOptions(this.scenePick, options(scenes), this.scene, say("bar.no_scene"));
    const chosen = station?.id ?? "";
    setOptions(this.stationPick, options(stations, nameOf), chosen, say("bar.no_station"));
  }

  private enter(scene: string): void {
    this.scene = scene;
    this.entered(scene);
  }

  private stationsHere(nowS: number): Station[] {
    return this.world
      .listed(nowS)
      .filter(
        (station) => station.scene === this.scene && (station.holdsTool || station.isMoving(nowS)),
      );
  }
}

import {type Object3D, type PerspectiveCamera, Vector3} from "three";

import {fdiOf} from "../model/fdi";
import {type Circle, layOut, type Point} from "../model/label_layout";
import {make, makeSvg} from "../ui/elements";
import type {BodyMesh} from "./body_mesh";

const kLabel = {width: 27, height: 19};
const kAir = 2; // between labels

interface Label {
  readonly text: HTMLSpanElement;
  readonly line: SVGLineElement;
  readonly within: Object3D; // which moves, where the tooth does
  readonly tooth: Vector3; // in it
  readonly wanted: Vector3;
}

/// The teeth's numbers over the picture, clear of the tools, each with a line to its tooth.
export class ToothLabels {
  private readonly lines = makeSvg("svg");
  private labels: Label[] = [];

  /// @param buttons  along its lower edge
  constructor(
    private readonly sheet: HTMLElement,
    private readonly buttons: HTMLElement,
  ) {
    sheet.append(this.lines);
  }

  setObjects(objects: readonly BodyMesh[]): void {
    for (const {text, line} of this.labels) {
      text.remove();
      line.remove();
    }
    this.labels = objects.flatMap((object) => {
      const number = fdiOf(object.body.name);
      return number === undefined ? [] : [this.makeLabel(number, object)];
    });
  }

  /// Whether any object is a numbered tooth.
  get any(): boolean {
    return this.labels.length > 0;
  }
  get shown(): boolean {
    return !this.sheet.hidden;
  }
  set shown(on: boolean) {
    this.sheet.hidden = !on;
  }

  update(eye: PerspectiveCamera, tools: readonly BodyMesh[]): void {
    if (!this.shown || this.labels.length === 0) return;
    const room = {width: this.sheet.clientWidth, height: this.sheet.clientHeight};
    const toPixels = (at: Vector3): Point => {
      const p = at.clone().project(eye);
      return {x: 0.5 * (p.x + 1) * room.width, y: 0.5 * (1 - p.y) * room.height};
    };
    const size = {width: kLabel.width + kAir, height: kLabel.height + kAir};
    const clear = tools.flatMap((tool) => circlesOf(tool, eye, toPixels, room.height));
    const placed = (at: Vector3, {within}: Label): Point =>
      toPixels(at.clone().applyMatrix4(within.matrixWorld));
    const wanted = this.labels.map((one) => placed(one.wanted, one));
    const free = {width: room.width, height: this.buttons.offsetTop};
    layOut(wanted, size, clear, free).forEach(({x, y}, i) => {
      const label = this.labels[i]!;
      const {text, line} = label;
      text.style.transform = `translate(${x - 0.5 * kLabel.width}px, ${y - 0.5 * kLabel.height}px)`;
      const end = placed(label.tooth, label);
      const ends = {x1: x, y1: y, x2: end.x, y2: end.y};
      for (const [name, value] of Object.entries(ends)) line.setAttribute(name, value.toFixed(1));
    });
  }

  private makeLabel(number: string, {mesh, group}: BodyMesh): Label {
    const text = make("span", number);
    text.style.width = `${kLabel.width}px`;
    text.style.height = `${kLabel.height}px`;
    this.sheet.append(text);
    const line = makeSvg("line");
    this.lines.append(line);
    mesh.geometry.computeBoundingBox();
    const {min, max} = mesh.geometry.boundingBox!;
    group.updateMatrix();
    // On the crown's outer side, then over the gum, where least is hidden.
    const inPlace = (y: number, z: number): Vector3 =>
      new Vector3(0, y, z).applyMatrix4(group.matrix);
    return {
      text,
      line,
      within: group.parent!,
      tooth: inPlace(0.55 * max.y, 0.9 * max.z),
      wanted: inPlace(0.45 * min.y, 1.6 * max.z),
    };
  }
}

/// Circles that cover a tool in the picture: from a level of its sphere tree that
/// follows its shape.
function circlesOf(
  tool: BodyMesh,
  eye: PerspectiveCamera,
  toPixels: (at: Vector3) => Point,
  height: number,
): Circle[] {
  const {levels} = tool.body.geometry;
  const {centres, radii} = levels[Math.min(1, levels.length - 1)]!;
  tool.group.updateMatrix();
  const perRadian = (0.5 * height) / Math.tan((0.5 * eye.fov * Math.PI) / 180);
  return Array.from(radii, (radius, i) => {
    const at = new Vector3().fromArray(centres, 3 * i).applyMatrix4(tool.group.matrix);
    return {
      ...toPixels(at),
      radius: (perRadian * radius) / Math.max(1e-6, at.distanceTo(eye.position)),
    };
  });
}

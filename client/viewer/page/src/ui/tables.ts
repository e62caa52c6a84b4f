import type {Station} from "../model/world";
import {deviceLines, type Line, sessionWords, statisticsLines} from "../model/words";
import {element, make, setText} from "./elements";

/// The loop's figures, the arm's and who drives what, in words.
export class Tables {
  private readonly loop = element("loop", HTMLTableElement);
  private readonly loopNone = element("loop-none", HTMLParagraphElement);
  private readonly arm = element("arm", HTMLTableElement);
  private readonly armNone = element("arm-none", HTMLParagraphElement);
  private readonly who = element("who", HTMLUListElement);
  private readonly whoNone = element("who-none", HTMLParagraphElement);

  updateLoop(station: Station | undefined): void {
    const lines = station?.statistics ? statisticsLines(station.statistics) : [];
    this.update(this.loop, this.loopNone, lines);
  }

  updateArm(station: Station | undefined, nowS: number): void {
    const device = station?.deviceNow(nowS);
    this.update(this.arm, this.armNone, device ? deviceLines(device) : []);
    if (device) setText(this.armNone, "No figures now.");
  }

  private update(table: HTMLTableElement, none: HTMLElement, lines: readonly Line[]): void {
    none.hidden = lines.length > 0;
    const body = table.tBodies[0]!;
    while (body.rows.length > lines.length) body.deleteRow(-1);
    lines.forEach(({label, value, remark, tone}, i) => {
      let row = body.rows[i];
      if (!row) {
        row = body.insertRow();
        row.append(make("th", {scope: "row"}));
        for (const className of ["value", "remark"]) row.append(make("td", {className}));
      }
      row.className = tone;
      [label, value, remark].forEach((text, column) => setText(row.cells[column]!, text));
    });
  }

  /// @param own  the station that this page's mouse is, where it is one
  updateWho(stations: readonly Station[], own: string): void {
    const listed = stations.filter((station) => station.session);
    this.whoNone.hidden = listed.length > 0;
    this.who.replaceChildren(
      ...listed.map((station) => {
        const name = make("b", {textContent: station.id});
        const item = make("li", {}, name, ` ${sessionWords(station.session!)}`);
        item.classList.toggle("gone", !station.holdsTool);
        item.classList.toggle("own", station.id === own);
        return item;
      }),
    );
  }
}

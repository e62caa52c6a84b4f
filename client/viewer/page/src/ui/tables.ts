import type {Station} from "../model/world";
import {sessionWords, statisticsLines} from "../model/words";
import {element, setText} from "./elements";

/// The loop's figures and who drives what, in words.
export class Tables {
  private readonly loop = element("loop", HTMLTableElement);
  private readonly loopNone = element("loop-none", HTMLParagraphElement);
  private readonly who = element("who", HTMLUListElement);
  private readonly whoNone = element("who-none", HTMLParagraphElement);

  updateLoop(station: Station | undefined): void {
    const lines = station?.statistics ? statisticsLines(station.statistics) : [];
    this.loopNone.hidden = lines.length > 0;
    const body = this.loop.tBodies[0]!;
    while (body.rows.length > lines.length) body.deleteRow(-1);
    lines.forEach(({label, value, remark, tone}, i) => {
      let row = body.rows[i];
      if (!row) {
        row = body.insertRow();
        const head = document.createElement("th");
        head.scope = "row";
        row.append(head);
        row.insertCell().className = "value";
        row.insertCell().className = "remark";
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
        const item = document.createElement("li");
        const name = document.createElement("b");
        name.textContent = station.id;
        item.classList.toggle("gone", !station.holdsTool);
        item.classList.toggle("own", station.id === own);
        item.append(name, ` ${sessionWords(station.session!)}`);
        return item;
      }),
    );
  }
}

/// Reads the names of a class from what a teacher pastes: a list, or a table of a spreadsheet or a
/// school's programme.

export interface PastedNames {
  readonly names: readonly string[];
  /// They were found in a table's columns, so that the teacher should look at them.
  readonly fromTable: boolean;
}

/// Headings of columns, in lower case.
const kGiven = new Set(
  "vorname,vornamen,rufname,first name,firstname,first names,given name,given names,forename,prénom,prenom,nombre,nombres,nome,имя,имя и отчество,imię,名,名字,이름".split(
    ",",
  ),
);
const kFamily = new Set(
  "nachname,familienname,zuname,last name,lastname,surname,family name,familyname,nom,nom de famille,apellido,apellidos,cognome,sobrenome,фамилия,nazwisko,姓,姓氏,성".split(
    ",",
  ),
);
const kWhole = new Set(
  "name,full name,fullname,student,student name,studierende,teilnehmer,teilnehmende,nom complet,nombre completo,фио,姓名,氏名,이름과 성,성명".split(
    ",",
  ),
);

/// Names whose family name comes first, without a space.
const kWithoutSpace = /^[\p{Script=Han}\p{Script=Hangul}]+$/u;
const kLetter = /\p{L}/u;

/// Splits rows after RFC 4180: a cell in quotes may hold separators, lines, and doubled quotes.
function rowsOf(text: string, separator: string): string[][] {
  const rows: string[][] = [[]];
  let cell = "";
  let quoted = false;
  const end = (): void => {
    rows.at(-1)!.push(cell.trim());
    cell = "";
  };
  for (let i = 0; i < text.length; i++) {
    const c = text.charAt(i);
    if (quoted) {
      if (c !== '"') cell += c;
      else if (text.charAt(i + 1) === '"') cell += text.charAt(++i);
      else quoted = false;
    } else if (c === '"' && cell.trim() === "") {
      [quoted, cell] = [true, ""];
    } else if (c === separator) end();
    else if (c === "\n") {
      end();
      rows.push([]);
    } else if (c !== "\r") cell += c;
  }
  end();
  return rows.filter((row) => row.some((one) => one !== ""));
}

/// Returns the text's rows if a separator gives each at least two cells.
function tableIn(text: string): string[][] | undefined {
  for (const separator of ["\t", ";", ","]) {
    const rows = rowsOf(text, separator);
    if (rows.length > 0 && rows.every((row) => row.length > 1)) return rows;
  }
  return undefined;
}

const headingOf = (cell: string): string =>
  cell
    .toLowerCase()
    .replace(/[._:*-]+/g, " ")
    .trim();

/// Returns the columns of given and family names, or of whole names; empty: there is no heading.
function namedColumns(row: readonly string[]): number[] {
  const headings = row.map(headingOf);
  const find = (words: ReadonlySet<string>): number => headings.findIndex((one) => words.has(one));
  const [given, family, whole] = [find(kGiven), find(kFamily), find(kWhole)];
  // "Name; Vorname": the first is the family's.
  const other = family >= 0 ? family : whole;
  return [given, given >= 0 ? other : whole >= 0 ? whole : family].filter((at) => at >= 0);
}

/// Whether a column holds names: letters, neither addresses nor numbers.
const holdsNames = (rows: readonly string[][], at: number): boolean =>
  rows.every((row) => !/[@\d/]/.test(row[at] ?? "")) &&
  rows.some((row) => kLetter.test(row[at] ?? ""));

/// Without headings the family's name comes first, as in "Weber;Anna;mail".
function guessedColumns(rows: readonly string[][]): number[] {
  const width = Math.max(...rows.map((row) => row.length));
  const columns = [...Array(width).keys()].filter((at) => holdsNames(rows, at));
  return columns.length > 1 ? [columns[1]!, columns[0]!] : columns;
}

export function namesIn(pasted: string): PastedNames {
  const text = pasted.replace(/^\ufeff/, "").trim();
  const rows = tableIn(text);
  const list = text.split(/\r?\n/).map((line) => line.replace(/^\s*"(.*)"\s*$/, "$1").trim());
  if (!rows) return {names: list.filter((name) => name !== ""), fromTable: false};
  const headed = namedColumns(rows[0]!);
  const people = headed.length > 0 ? rows.slice(1) : rows;
  const columns = headed.length > 0 ? headed : guessedColumns(people);
  const names = people.map((row) => {
    const parts = columns.map((at) => row[at] ?? "").filter((part) => part !== "");
    return parts.every((part) => kWithoutSpace.test(part))
      ? [...parts].reverse().join("")
      : parts.join(" ");
  });
  const lines = names.map((name) => name.replace(/\s+/g, " "));
  return {names: lines.filter((name) => name !== ""), fromTable: true};
}

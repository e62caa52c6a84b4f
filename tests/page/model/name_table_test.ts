import {expect, test} from "vitest";
import {namesIn} from "../../../client/page/src/model/name_table";

const table = (text: string): readonly string[] => {
  const {names, fromTable} = namesIn(text);
  expect(fromTable).toBe(true);
  return names;
};

test("a list has a name in each line", () => {
  expect(namesIn('\ufeff Anna \r\n\n"Ben"\nEva Müller\n')).toEqual({
    names: ["Anna", "Ben", "Eva Müller"],
    fromTable: false,
  });
});

test("a table without headings has the family's name first, and other columns are left out", () => {
  expect(table("Weber;Anna;anna@school.de\nMüller;Jan Ole;jan@school.de")).toEqual([
    "Anna Weber",
    "Jan Ole Müller",
  ]);
  expect(table("4711\tWeber\tAnna\t12/2003\n4712\tØ\tBo\t1/2004")).toEqual(["Anna Weber", "Bo Ø"]);
  expect(table("Weber, Anna\nde la Cruz, José")).toEqual(["Anna Weber", "José de la Cruz"]);
  expect(table("Anna Weber;anna@school.de")).toEqual(["Anna Weber"]);
  expect(table("王;伟;a@b.cn\n欧阳;小龙;c@d.cn")).toEqual(["王伟", "欧阳小龙"]);
});

test("headings name the columns, in any order", () => {
  expect(table("\ufeffVorname;Nachname;E-Mail\nAnna;Weber;a@b")).toEqual(["Anna Weber"]);
  expect(table("Name,Vorname,Klasse\nWeber,Anna,8b")).toEqual(["Anna Weber"]);
  expect(table("First name\tSurname\tID number\nAnna\tWeber\t7")).toEqual(["Anna Weber"]);
  expect(table("Matrikel;Name\n12;Anna Weber")).toEqual(["Anna Weber"]);
  expect(table("姓,名\n李,娜")).toEqual(["李娜"]);
  expect(table("Фамилия;Имя\nИванов;Пётр")).toEqual(["Пётр Иванов"]);
});

test("a cell in quotes holds separators, quotes and lines", () => {
  expect(table('Name;Mail\r\n"Weber; Anna ""Anni""";a@b\r\n')).toEqual(['Weber; Anna "Anni"']);
  expect(table('"Name","Note"\n"Anna\nWeber","x, y"')).toEqual(["Anna Weber"]);
});

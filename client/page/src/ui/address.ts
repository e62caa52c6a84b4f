/// Stores a value in the address, so that a teacher can pass on a link to the present view.
export function rememberInAddress(name: string, value: string): void {
  const url = new URL(location.href);
  if (value === "") url.searchParams.delete(name);
  else url.searchParams.set(name, value);
  history.replaceState(null, "", url);
}

/// The page's time.
export const nowS = (): number => performance.now() / 1000;

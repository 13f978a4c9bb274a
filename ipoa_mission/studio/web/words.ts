// Numbers as one says them.
export const meters = (value: number, digits = 1): string => `${value.toFixed(digits)} m`;

export function seconds(value: number): string {
  if (value < 100) return `${value.toFixed(1)} s`;
  return `${Math.floor(value / 60)}:${String(Math.round(value % 60)).padStart(2, "0")} min`;
}

export const share = (value: number): string => `${+(100 * value).toFixed(1)} %`;

/** What the numbers of a survey mean, where their names do not say it. */
export const SURVEY_HELP: Record<string, string> = {
  height_above_ground: "Above the highest ground that is seen, at least; over ground that is not flat up to 15 % more",
  front_overlap: "Share of a photo that the next one shows too, at least",
  side_overlap: "Share of a photo that those of the next line show too, at least",
  turns_outside: "How far beyond the area the vehicle may be told to fly to turn",
  flights: "Left empty: as few as the battery is enough for, each with its reserve",
};

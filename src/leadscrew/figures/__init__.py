"""What studies, reports and notebooks draw and print with: tables, numbers, units."""

"""Between the browser and the page: access control, uploads, clicks."""
